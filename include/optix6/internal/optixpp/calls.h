// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API: helpers of its member functions.
#ifndef SUNSTONE_OPTIXPP_CALLS_H
#define SUNSTONE_OPTIXPP_CALLS_H

#include "context.h"
#include "data.h"
#include "geometry.h"
#include "handle.h"
#include "nodes.h"
#include "variable.h"

namespace optix {

namespace internal {

/** The object of the C API; null for a null handle, which the C function rejects. */
template <class T>
inline typename T::api_t api(Handle<T> handle) {
    return handle ? handle->get() : 0;
}

inline std::vector<const char*> pointers(const std::vector<std::string>& strings) {
    std::vector<const char*> result;
    for (std::vector<std::string>::size_type i = 0; i < strings.size(); ++i)
        result.push_back(strings[i].c_str());
    return result;
}

/** The stride of packed vectors; 0, which the C function rejects, for other formats. */
inline RTsize sizeOf(RTformat format) {
    const struct {
        RTformat first; // of formats with one to four components
        RTsize bytes;
    } families[] = {{RT_FORMAT_FLOAT, 4},          {RT_FORMAT_BYTE, 1},
                    {RT_FORMAT_UNSIGNED_BYTE, 1},  {RT_FORMAT_SHORT, 2},
                    {RT_FORMAT_UNSIGNED_SHORT, 2}, {RT_FORMAT_INT, 4},
                    {RT_FORMAT_UNSIGNED_INT, 4},   {RT_FORMAT_HALF, 2}};
    for (unsigned int i = 0; i < sizeof(families) / sizeof(families[0]); ++i) {
        const unsigned int components =
            static_cast<unsigned int>(format) - static_cast<unsigned int>(families[i].first) + 1;
        if (components >= 1 && components <= 4)
            return components * families[i].bytes;
    }
    return 0;
}

} // namespace internal

template <class T>
inline Handle<VariableObj> Handle<T>::operator[](const std::string& varname) {
    Handle<VariableObj> variable = checked()->queryVariable(varname);
    return variable ? variable : checked()->declareVariable(varname);
}
template <class T>
inline Handle<VariableObj> Handle<T>::operator[](const char* varname) {
    return (*this)[std::string(varname ? varname : "")];
}

inline void APIObj::checkError(RTresult code) const {
    if (code == RT_SUCCESS || code == RT_TIMEOUT_CALLBACK)
        return;
    RTcontext context = 0;
    try {
        context = internal::api(getContext());
    } catch (const Exception&) { // the object is dead; the code has a general text
    }
    internal::check(code, context);
}

inline void APIObj::checkError(RTresult code, Context context) const {
    internal::check(code, internal::api(context));
}

} // namespace optix

#endif
