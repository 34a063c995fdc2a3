// SPDX-License-Identifier: Apache-2.0
// Every setter and getter of plain values: both getters return a set value, and programs read it.
#include "support.h"

#include <array>
#include <chrono>

namespace sunstone::api6 {
namespace {

class Values : public Classic {
protected:
    void SetUp() override {
        Classic::SetUp();
        ok(rtBufferCreate(context_, RT_BUFFER_OUTPUT, &numbers_));
        ok(rtBufferSetFormat(numbers_, RT_FORMAT_USER));
        ok(rtBufferSetElementSize(numbers_, sizeof(double)));
        ok(rtBufferSetSize1D(numbers_, kNumbers));
        ok(rtVariableSetObject(variable("numbers"), numbers_));
    }
    // The values that the program writes.
    std::vector<double> written(const std::string& name, size_t count) {
        RTprogram made = nullptr;
        ok(rtProgramCreateFromPTXString(context_, ptx("values.ptx").c_str(), name.c_str(), &made));
        ok(rtContextSetRayGenerationProgram(context_, 0, made));
        ok(rtContextLaunch1D(context_, 0, 1));
        void* data = nullptr;
        ok(rtBufferMap(numbers_, &data));
        const auto* begin = static_cast<const double*>(data);
        std::vector<double> result(begin, begin + count);
        ok(rtBufferUnmap(numbers_));
        return result;
    }
    template <class T>
    static std::vector<double> asDoubles(const std::vector<T>& values) {
        return {values.begin(), values.end()};
    }
    void expectType(RTvariable v, unsigned wanted, size_t bytes) {
        RTobjecttype type{};
        RTsize size = 0;
        ok(rtVariableGetType(v, &type));
        EXPECT_EQ(unsigned(type), wanted);
        ok(rtVariableGetSize(v, &size));
        EXPECT_EQ(size, bytes);
    }

    static constexpr size_t kNumbers = 16;
    RTbuffer numbers_ = nullptr;
};

// The functions of one type of components.
template <class T>
struct Functions {
    RTresult (*set1)(RTvariable, T);
    RTresult (*set2)(RTvariable, T, T);
    RTresult (*set3)(RTvariable, T, T, T);
    RTresult (*set4)(RTvariable, T, T, T, T);
    RTresult (*setv[4])(RTvariable, const T*);
    RTresult (*get1)(RTvariable, T*);
    RTresult (*get2)(RTvariable, T*, T*);
    RTresult (*get3)(RTvariable, T*, T*, T*);
    RTresult (*get4)(RTvariable, T*, T*, T*, T*);
    RTresult (*getv[4])(RTvariable, T*);
};
#define FUNCTIONS(letters)                                                                         \
    {                                                                                              \
        rtVariableSet1##letters, rtVariableSet2##letters, rtVariableSet3##letters,                 \
            rtVariableSet4##letters,                                                               \
            {rtVariableSet1##letters##v, rtVariableSet2##letters##v, rtVariableSet3##letters##v,   \
             rtVariableSet4##letters##v},                                                          \
            rtVariableGet1##letters, rtVariableGet2##letters, rtVariableGet3##letters,             \
            rtVariableGet4##letters, {                                                             \
            rtVariableGet1##letters##v, rtVariableGet2##letters##v, rtVariableGet3##letters##v,    \
                rtVariableGet4##letters##v                                                         \
        }                                                                                          \
    }

class Components : public Values {
protected:
    // Ten values, for the variables of one, two, three and four components.
    template <class T>
    void check(const Functions<T>& f, const std::string& letters, unsigned type, std::vector<T> a) {
        std::vector<RTvariable> v;
        for (const char* name : {"_one", "_two", "_three", "_four"})
            v.push_back(variable((letters + name).c_str()));
        ok(f.set1(v[0], a[0]));
        ok(f.set2(v[1], a[1], a[2]));
        ok(f.set3(v[2], a[3], a[4], a[5]));
        ok(f.set4(v[3], a[6], a[7], a[8], a[9]));
        expectValues(f, v, a);
        EXPECT_EQ(written("write_" + letters, 10), asDoubles(a));
        for (unsigned n = 0; n < 4; ++n)
            expectType(v[n], type + n, (n + 1) * sizeof(T));
        for (T& value : a)
            value += T(3);
        for (size_t n = 0; n < 4; ++n)
            ok(f.setv[n](v[n], a.data() + n * (n + 1) / 2));
        expectValues(f, v, a);
        EXPECT_EQ(written("write_" + letters, 10), asDoubles(a));
    }

private:
    template <class T>
    void expectValues(const Functions<T>& f, const std::vector<RTvariable>& v,
                      const std::vector<T>& wanted) {
        std::vector<T> parts(10), arrays(10);
        T* const p = parts.data();
        ok(f.get1(v[0], p));
        ok(f.get2(v[1], p + 1, p + 2));
        ok(f.get3(v[2], p + 3, p + 4, p + 5));
        ok(f.get4(v[3], p + 6, p + 7, p + 8, p + 9));
        EXPECT_EQ(parts, wanted);
        for (size_t n = 0; n < 4; ++n)
            ok(f.getv[n](v[n], arrays.data() + n * (n + 1) / 2));
        EXPECT_EQ(arrays, wanted);
    }
};

TEST_F(Components, OfFloats) {
    check<float>(FUNCTIONS(f), "f", RT_OBJECTTYPE_FLOAT,
                 {1.5f, -2.25f, 3, 4, 5, 6, 7, 8, 9, 1e20f});
}
TEST_F(Components, OfInts) {
    check<int>(FUNCTIONS(i), "i", RT_OBJECTTYPE_INT, {-1, 2, -3, 4, 5, 6, 7, 8, 9, -2000000000});
}
TEST_F(Components, OfUnsignedInts) {
    check<unsigned>(FUNCTIONS(ui), "ui", RT_OBJECTTYPE_UNSIGNED_INT,
                    {1, 2, 3, 4, 5, 6, 7, 8, 9, 4000000000u});
}
TEST_F(Components, OfLongLongs) {
    const long long large = 1LL << 40;
    check<long long>(FUNCTIONS(ll), "ll", RT_OBJECTTYPE_LONG_LONG,
                     {-large, large + 1, 3, -4, 5, large + 6, 7, 8, 9, -large - 10});
}
TEST_F(Components, OfUnsignedLongLongs) {
    const unsigned long long large = 1ULL << 50;
    check<unsigned long long>(FUNCTIONS(ull), "ull", RT_OBJECTTYPE_UNSIGNED_LONG_LONG,
                              {large, large + 1, 3, 4, 5, large + 6, 7, 8, 9, large + 10});
}

struct MatrixCase {
    const char* size;
    unsigned rows, columns, type;
    RTresult (*set)(RTvariable, int, const float*);
    RTresult (*get)(RTvariable, int, float*);
};
#define MATRIX(n, m)                                                                               \
    MatrixCase {                                                                                   \
        #n "x" #m, n, m, RT_OBJECTTYPE_MATRIX_FLOAT##n##x##m, rtVariableSetMatrix##n##x##m##fv,    \
            rtVariableGetMatrix##n##x##m##fv                                                       \
    }
const MatrixCase kMatrices[] = {MATRIX(2, 2), MATRIX(2, 3), MATRIX(2, 4),
                                MATRIX(3, 2), MATRIX(3, 3), MATRIX(3, 4),
                                MATRIX(4, 2), MATRIX(4, 3), MATRIX(4, 4)};

TEST_F(Values, OfMatrices) {
    for (const MatrixCase& each : kMatrices) {
        SCOPED_TRACE(each.size);
        const size_t count = size_t(each.rows) * each.columns;
        std::vector<float> rows(count), turned(count), found(count);
        for (unsigned r = 0; r < each.rows; ++r)
            for (unsigned c = 0; c < each.columns; ++c) {
                rows[r * each.columns + c] = turned[c * each.rows + r] =
                    float(10 * (r + 1) + c) + 0.5f;
            }
        RTvariable v = variable((std::string("matrix") + each.size).c_str());
        for (const int transposed : {0, 1}) {
            ok(each.set(v, transposed, transposed ? turned.data() : rows.data()));
            ok(each.get(v, 0, found.data()));
            EXPECT_EQ(found, rows);
            ok(each.get(v, 1, found.data()));
            EXPECT_EQ(found, turned);
            EXPECT_EQ(written(std::string("write_") + each.size, count), asDoubles(rows));
            // The next turn starts from other values.
            found.assign(count, -1.0f);
        }
        expectType(v, each.type, count * sizeof(float));
    }
}

// A search by name takes as long among many variables of an object as among few.
TEST_F(Values, OfManyNames) {
    const auto nameOf = [](unsigned i) { return "number" + std::to_string(i); };
    const auto secondsOfSearches = [&](unsigned count) {
        double best = 1e9;
        for (unsigned turn = 0; turn < 5; ++turn) {
            const auto start = std::chrono::steady_clock::now();
            for (unsigned i = 0; i < 2000; ++i)
                variable(nameOf((i * 7919) % count).c_str());
            const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
            best = std::min(best, time.count());
        }
        return best;
    };
    for (unsigned i = 0; i < 20000; ++i) {
        if (i % 1000 == 500) {
            RTvariable removed = variable(nameOf(i - 1).c_str());
            ok(rtContextRemoveVariable(context_, removed));
            variable(nameOf(i - 1).c_str());
        }
        ok(rtVariableSet1ui(variable(nameOf(i).c_str()), i));
    }
    for (unsigned i = 0; i < 20000; i += 999) {
        unsigned value = 0;
        ok(rtVariableGet1ui(variable(nameOf(i).c_str()), &value));
        EXPECT_EQ(value, i);
    }
    const double many = secondsOfSearches(20000);
    EXPECT_LT(many, 5 * secondsOfSearches(20)) << "the first twenty";
}

} // namespace
} // namespace sunstone::api6
