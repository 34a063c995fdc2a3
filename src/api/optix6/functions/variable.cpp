// SPDX-License-Identifier: Apache-2.0
// Entry points of variables (sections 5.16 to 5.18), and of the objects that hold them.
#include "api/optix6/call.h"
#include "api/optix6/scene.h"

#include <algorithm>
#include <cstring>

using namespace sunstone;
using namespace sunstone::optix6;

// ---- scopes -----------------------------------------------------------------------------------

namespace {

void declare(Scoped& object, Context& context, const char* name, RTvariable* v) {
    requireNonNull(v, "v");
    *v = nullptr;
    requireNonNull(name, "name");
    if (!isVariableName(name))
        refuse(RT_ERROR_ILLEGAL_SYMBOL, "name = \"", name, "\" is not the name of a variable");
    if (object.scope.find(name))
        refuse(RT_ERROR_VARIABLE_REDECLARED, "variable \"", name, "\" of the ", nameOf(object.kind),
               " exists");
    auto variable = std::make_shared<Variable>(context.self(), name, &object);
    *v = static_cast<RTvariable>(objects().add(variable));
    object.scope.add(variable);
    auto& all = context.variables;
    if (all.size() == all.capacity())
        all.erase(std::remove_if(all.begin(), all.end(), [](const auto& r) { return r.expired(); }),
                  all.end());
    all.push_back(variable);
    if (variable->isSeen())
        context.noteStructure();
}

void query(Scoped& object, const char* name, RTvariable* v) {
    requireNonNull(v, "v");
    *v = nullptr;
    requireNonNull(name, "name");
    if (const std::shared_ptr<Variable> found = object.scope.find(name))
        *v = static_cast<RTvariable>(found->handle());
}

void removeVariable(Scoped& object, Context& context, RTvariable v) {
    const std::shared_ptr<Variable> variable = require<Variable>(v, "v");
    if (!object.scope.remove(variable))
        refuse(RT_ERROR_VARIABLE_NOT_FOUND, "v = \"", variable->name,
               "\" is not a variable of the ", nameOf(object.kind));
    objects().remove(v);
    if (variable->isSeen())
        context.noteStructure();
}

void variableAt(Scoped& object, unsigned index, RTvariable* v, RTresult outside) {
    requireNonNull(v, "v");
    *v = nullptr;
    const auto& list = object.scope.list();
    if (index >= list.size())
        refuse(outside, "index = ", index, " of ", list.size(), " variables");
    *v = static_cast<RTvariable>(list[index]->handle());
}

} // namespace

// `outside`: the result for an index out of range.
#define SUNSTONE_SCOPE(Class, Handle, parameter, outside)                                          \
    SUNSTONE_API RTresult rt##Class##DeclareVariable(Handle h, const char* name, RTvariable* v) {  \
        return SUNSTONE_CALL(Class, parameter,                                                     \
                             [&](Class& object) { declare(object, *object.context(), name, v); }); \
    }                                                                                              \
    SUNSTONE_API RTresult rt##Class##QueryVariable(Handle h, const char* name, RTvariable* v) {    \
        return SUNSTONE_CALL(Class, parameter, [&](Class& object) { query(object, name, v); });    \
    }                                                                                              \
    SUNSTONE_API RTresult rt##Class##RemoveVariable(Handle h, RTvariable v) {                      \
        return SUNSTONE_CALL(Class, parameter, [&](Class& object) {                                \
            removeVariable(object, *object.context(), v);                                          \
        });                                                                                        \
    }                                                                                              \
    SUNSTONE_API RTresult rt##Class##GetVariableCount(Handle h, unsigned* count) {                 \
        return SUNSTONE_CALL(Class, parameter, [&](Class& object) {                                \
            store(count, "count", unsigned(object.scope.list().size()));                           \
        });                                                                                        \
    }                                                                                              \
    SUNSTONE_API RTresult rt##Class##GetVariable(Handle h, unsigned index, RTvariable* v) {        \
        return SUNSTONE_CALL(Class, parameter,                                                     \
                             [&](Class& object) { variableAt(object, index, v, outside); });       \
    }
#define SUNSTONE_CALL(Class, parameter, ...) call<Class>(__func__, h, parameter, __VA_ARGS__)
SUNSTONE_SCOPE(Program, RTprogram, "program", RT_ERROR_VARIABLE_NOT_FOUND)
SUNSTONE_SCOPE(Selector, RTselector, "selector", RT_ERROR_INVALID_VALUE)
SUNSTONE_SCOPE(GeometryInstance, RTgeometryinstance, "geometryinstance",
               RT_ERROR_VARIABLE_NOT_FOUND)
SUNSTONE_SCOPE(Geometry, RTgeometry, "geometry", RT_ERROR_VARIABLE_NOT_FOUND)
SUNSTONE_SCOPE(GeometryTriangles, RTgeometrytriangles, "geometrytriangles", RT_ERROR_INVALID_VALUE)
SUNSTONE_SCOPE(Material, RTmaterial, "material", RT_ERROR_VARIABLE_NOT_FOUND)
#undef SUNSTONE_CALL
#define SUNSTONE_CALL(Class, parameter, ...) callContext(__func__, h, __VA_ARGS__)
SUNSTONE_SCOPE(Context, RTcontext, "context", RT_ERROR_INVALID_VALUE)
#undef SUNSTONE_CALL
#undef SUNSTONE_SCOPE

// ---- values -----------------------------------------------------------------------------------

namespace {

template <class T>
RTresult set(const char* function, RTvariable v, RTobjecttype type, const T* data, size_t count) {
    return call<Variable>(function, v, "v", [&](Variable& variable) {
        requireNonNull(data, "the data");
        variable.set(type, data, count * sizeof(T));
    });
}

template <class T>
RTresult get(const char* function, RTvariable v, RTobjecttype type, T* data, size_t count) {
    return call<Variable>(function, v, "v", [&](Variable& variable) {
        requireNonNull(data, "the result");
        variable.get(type, data, count * sizeof(T));
    });
}

template <class T, size_t N>
RTresult getParts(const char* function, RTvariable v, RTobjecttype type, T* const (&parts)[N]) {
    return call<Variable>(function, v, "v", [&](Variable& variable) {
        for (T* part : parts)
            requireNonNull(part, "a result");
        T data[N];
        variable.get(type, data, sizeof data);
        for (size_t i = 0; i < N; ++i)
            *parts[i] = data[i];
    });
}

// Rows of `columns` to columns of `rows`.
void transposed(const float* from, float* to, unsigned rows, unsigned columns) {
    for (unsigned row = 0; row < rows; ++row)
        for (unsigned column = 0; column < columns; ++column)
            to[column * rows + row] = from[row * columns + column];
}

RTresult setMatrix(const char* function, RTvariable v, RTobjecttype type, int transpose,
                   const float* m, unsigned rows, unsigned columns) {
    float data[16];
    if (m && transpose)
        transposed(m, data, columns, rows);
    return set(function, v, type, m && transpose ? data : m, size_t(rows) * columns);
}

RTresult getMatrix(const char* function, RTvariable v, RTobjecttype type, int transpose, float* m,
                   unsigned rows, unsigned columns) {
    return call<Variable>(function, v, "v", [&](Variable& variable) {
        requireNonNull(m, "m");
        float data[16];
        variable.get(type, data, sizeof(float) * rows * columns);
        if (transpose)
            transposed(data, m, rows, columns);
        else
            std::memcpy(m, data, sizeof(float) * rows * columns);
    });
}

} // namespace

#define SUNSTONE_VALUES(letters, T, TYPE)                                                          \
    SUNSTONE_API RTresult rtVariableSet1##letters(RTvariable v, T a) {                             \
        const T data[] = {a};                                                                      \
        return set(__func__, v, TYPE, data, 1);                                                    \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableSet2##letters(RTvariable v, T a, T b) {                        \
        const T data[] = {a, b};                                                                   \
        return set(__func__, v, TYPE##2, data, 2);                                                 \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableSet3##letters(RTvariable v, T a, T b, T c) {                   \
        const T data[] = {a, b, c};                                                                \
        return set(__func__, v, TYPE##3, data, 3);                                                 \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableSet4##letters(RTvariable v, T a, T b, T c, T d) {              \
        const T data[] = {a, b, c, d};                                                             \
        return set(__func__, v, TYPE##4, data, 4);                                                 \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableSet1##letters##v(RTvariable v, const T* p) {                   \
        return set(__func__, v, TYPE, p, 1);                                                       \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableSet2##letters##v(RTvariable v, const T* p) {                   \
        return set(__func__, v, TYPE##2, p, 2);                                                    \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableSet3##letters##v(RTvariable v, const T* p) {                   \
        return set(__func__, v, TYPE##3, p, 3);                                                    \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableSet4##letters##v(RTvariable v, const T* p) {                   \
        return set(__func__, v, TYPE##4, p, 4);                                                    \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableGet1##letters(RTvariable v, T* a) {                            \
        return getParts(__func__, v, TYPE, {a});                                                   \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableGet2##letters(RTvariable v, T* a, T* b) {                      \
        return getParts(__func__, v, TYPE##2, {a, b});                                             \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableGet3##letters(RTvariable v, T* a, T* b, T* c) {                \
        return getParts(__func__, v, TYPE##3, {a, b, c});                                          \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableGet4##letters(RTvariable v, T* a, T* b, T* c, T* d) {          \
        return getParts(__func__, v, TYPE##4, {a, b, c, d});                                       \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableGet1##letters##v(RTvariable v, T* p) {                         \
        return get(__func__, v, TYPE, p, 1);                                                       \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableGet2##letters##v(RTvariable v, T* p) {                         \
        return get(__func__, v, TYPE##2, p, 2);                                                    \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableGet3##letters##v(RTvariable v, T* p) {                         \
        return get(__func__, v, TYPE##3, p, 3);                                                    \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableGet4##letters##v(RTvariable v, T* p) {                         \
        return get(__func__, v, TYPE##4, p, 4);                                                    \
    }
SUNSTONE_VALUES(f, float, RT_OBJECTTYPE_FLOAT)
SUNSTONE_VALUES(i, int, RT_OBJECTTYPE_INT)
SUNSTONE_VALUES(ui, unsigned int, RT_OBJECTTYPE_UNSIGNED_INT)
SUNSTONE_VALUES(ll, long long, RT_OBJECTTYPE_LONG_LONG)
SUNSTONE_VALUES(ull, unsigned long long, RT_OBJECTTYPE_UNSIGNED_LONG_LONG)
#undef SUNSTONE_VALUES

#define SUNSTONE_MATRIX(N, M)                                                                      \
    SUNSTONE_API RTresult rtVariableSetMatrix##N##x##M##fv(RTvariable v, int transpose,            \
                                                           const float* m) {                       \
        return setMatrix(__func__, v, RT_OBJECTTYPE_MATRIX_FLOAT##N##x##M, transpose, m, N, M);    \
    }                                                                                              \
    SUNSTONE_API RTresult rtVariableGetMatrix##N##x##M##fv(RTvariable v, int transpose,            \
                                                           float* m) {                             \
        return getMatrix(__func__, v, RT_OBJECTTYPE_MATRIX_FLOAT##N##x##M, transpose, m, N, M);    \
    }
SUNSTONE_MATRIX(2, 2)
SUNSTONE_MATRIX(2, 3)
SUNSTONE_MATRIX(2, 4)
SUNSTONE_MATRIX(3, 2)
SUNSTONE_MATRIX(3, 3)
SUNSTONE_MATRIX(3, 4)
SUNSTONE_MATRIX(4, 2)
SUNSTONE_MATRIX(4, 3)
SUNSTONE_MATRIX(4, 4)
#undef SUNSTONE_MATRIX

SUNSTONE_API RTresult rtVariableSetObject(RTvariable v, RTobject handle) {
    return call<Variable>(__func__, v, "v", [&](Variable& variable) {
        requireNonNull(handle, "object");
        const std::shared_ptr<Object> object = objects().find(handle);
        if (!object)
            refuse(RT_ERROR_INVALID_VALUE, "object = ", handle, " is not a live object");
        const bool fits = isNode(object->kind) || object->kind == Kind::kBuffer ||
                          object->kind == Kind::kTextureSampler || object->kind == Kind::kProgram;
        if (!fits)
            refuse(RT_ERROR_TYPE_MISMATCH, "object is a ", nameOf(object->kind),
                   ", which no variable can have as its value");
        if (object->context() != variable.context())
            refuse(RT_ERROR_INVALID_VALUE, "object belongs to another context");
        variable.set(object);
    });
}

SUNSTONE_API RTresult rtVariableGetObject(RTvariable v, RTobject* object) {
    return call<Variable>(__func__, v, "v", [&](Variable& variable) {
        requireNonNull(object, "object");
        *object = nullptr;
        if (variable.type == RT_OBJECTTYPE_UNKNOWN || !variable.bytes.empty())
            refuse(RT_ERROR_TYPE_MISMATCH, "variable \"", variable.name, "\" has no object");
        *object = handleOf(variable.object);
    });
}

SUNSTONE_API RTresult rtVariableSetUserData(RTvariable v, RTsize size, const void* data) {
    return call<Variable>(__func__, v, "v", [&](Variable& variable) {
        requireNonNull(data, "ptr");
        constexpr RTsize kMost = RTsize(1) << 20;
        if (size == 0 || size > kMost)
            refuse(RT_ERROR_INVALID_VALUE, "size = ", size, " is outside 1..", kMost);
        variable.set(RT_OBJECTTYPE_USER, data, size);
    });
}

SUNSTONE_API RTresult rtVariableGetUserData(RTvariable v, RTsize size, void* data) {
    return call<Variable>(__func__, v, "v", [&](Variable& variable) {
        requireNonNull(data, "ptr");
        if (variable.type != RT_OBJECTTYPE_USER)
            refuse(RT_ERROR_TYPE_MISMATCH, "variable \"", variable.name, "\" has no user data");
        if (variable.bytes.size() != size)
            refuse(RT_ERROR_INVALID_VALUE, "size = ", size, ", but the variable has ",
                   variable.bytes.size(), " bytes");
        std::memcpy(data, variable.bytes.data(), size);
    });
}

SUNSTONE_API RTresult rtVariableGetName(RTvariable v, const char** name) {
    if (name)
        *name = nullptr;
    return call<Variable>(__func__, v, "v", [&](Variable& variable) {
        requireNonNull(name, "nameReturn");
        *name = variable.context()->keep(variable.name);
    });
}

SUNSTONE_API RTresult rtVariableGetAnnotation(RTvariable v, const char** annotation) {
    if (annotation)
        *annotation = nullptr;
    return call<Variable>(__func__, v, "v", [&](Variable& variable) {
        requireNonNull(annotation, "annotationReturn");
        Context& context = *variable.context();
        *annotation = context.keep(context.annotationOf(variable.name));
    });
}

SUNSTONE_API RTresult rtVariableGetType(RTvariable v, RTobjecttype* type) {
    if (type)
        *type = RT_OBJECTTYPE_UNKNOWN;
    return call<Variable>(__func__, v, "v",
                          [&](Variable& variable) { store(type, "typeReturn", variable.type); });
}

SUNSTONE_API RTresult rtVariableGetContext(RTvariable v, RTcontext* context) {
    return call<Variable>(__func__, v, "v", [&](Variable& variable) {
        if (context)
            *context = static_cast<RTcontext>(variable.context()->handle());
    });
}

SUNSTONE_API RTresult rtVariableGetSize(RTvariable v, RTsize* size) {
    return call<Variable>(__func__, v, "v", [&](Variable& variable) {
        requireNonNull(size, "size");
        if (variable.bytes.empty())
            refuse(RT_ERROR_INVALID_VALUE, "variable \"", variable.name,
                   "\" has no plain data as its value");
        *size = variable.bytes.size();
    });
}
