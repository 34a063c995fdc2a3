// SPDX-License-Identifier: Apache-2.0
// Functions on top of the classic API, for the host: children of nodes, names and sizes of types,
// CUDA sources to PTX. Source: OptiX API reference 6.0, sections 5.28, 8.28.
#ifndef SUNSTONE_OPTIXU_H
#define SUNSTONE_OPTIXU_H

#include "../optix_host.h"

#include <stddef.h>

#define RTU_INLINE static inline

/* Returns from the calling function with the code of a failed call. */
#define RTU_CHECK_ERROR(func)                                                                      \
    do {                                                                                           \
        RTresult code = func;                                                                      \
        if (code != RT_SUCCESS)                                                                    \
            return code;                                                                           \
    } while (0)

/* Appends a child and returns from the calling function; *_index is its index if _index is set. */
#define RTU_GROUP_ADD_CHILD(_parent, _child, _index)                                               \
    SUNSTONE_RTU_ADD_CHILD(rtGroup, _parent, _child, _index)
#define RTU_SELECTOR_ADD_CHILD(_parent, _child, _index)                                            \
    SUNSTONE_RTU_ADD_CHILD(rtSelector, _parent, _child, _index)
#define SUNSTONE_RTU_ADD_CHILD(prefix, _parent, _child, _index)                                    \
    unsigned int _count;                                                                           \
    RTU_CHECK_ERROR(prefix##GetChildCount((_parent), &_count));                                    \
    RTU_CHECK_ERROR(prefix##SetChildCount((_parent), _count + 1));                                 \
    RTU_CHECK_ERROR(prefix##SetChild((_parent), _count, (_child)));                                \
    if (_index)                                                                                    \
        *(_index) = _count;                                                                        \
    return RT_SUCCESS

#ifdef __cplusplus
extern "C" {
#endif

/* The name of a type, with its terminator, in bufferSize bytes. */
RTresult RTAPI rtuNameForType(RTobjecttype type, char* buffer, RTsize bufferSize);
/* The bytes of an element; of a block for block formats; 0 for RT_FORMAT_USER and _UNKNOWN. */
RTresult RTAPI rtuGetSizeForRTformat(RTformat format, size_t* size);
/* CUDA to PTX; the sizes are those of the strings that rtuCUDAGetCompileResult writes. */
RTresult RTAPI rtuCUDACompileString(const char* source, const char** preprocessorArguments,
                                    unsigned int numPreprocessorArguments, RTsize* resultSize,
                                    RTsize* errorSize);
RTresult RTAPI rtuCUDACompileFile(const char* filename, const char** preprocessorArguments,
                                  unsigned int numPreprocessorArguments, RTsize* resultSize,
                                  RTsize* errorSize);
/* PTX and messages of the latest compilation. */
RTresult RTAPI rtuCUDAGetCompileResult(char* result, char* error);

#ifdef __cplusplus
}
#endif

/* The functions of a kind of parent. Adding appends; *index receives the child's index unless index
   is null. Removing moves the last child to the place of the removed one. RT_ERROR_INVALID_VALUE:
   the object is no child of the parent, or the index is beyond the count. */
#define SUNSTONE_RTU_CHILDREN(Name, Parent, Child)                                                 \
    RTU_INLINE RTresult rtu##Name##AddChild(Parent parent, Child child, unsigned int* index) {     \
        SUNSTONE_RTU_ADD_CHILD(rt##Name, parent, child, index);                                    \
    }                                                                                              \
    RTU_INLINE RTresult rtu##Name##GetChildIndex(Parent parent, Child child,                       \
                                                 unsigned int* index) {                            \
        unsigned int count, i;                                                                     \
        Child other;                                                                               \
        if (!index)                                                                                \
            return RT_ERROR_INVALID_VALUE;                                                         \
        RTU_CHECK_ERROR(rt##Name##GetChildCount(parent, &count));                                  \
        for (i = 0; i < count; ++i) {                                                              \
            RTU_CHECK_ERROR(rt##Name##GetChild(parent, i, &other));                                \
            if (other == child) {                                                                  \
                *index = i;                                                                        \
                return RT_SUCCESS;                                                                 \
            }                                                                                      \
        }                                                                                          \
        return RT_ERROR_INVALID_VALUE;                                                             \
    }                                                                                              \
    RTU_INLINE RTresult rtu##Name##RemoveChildByIndex(Parent parent, unsigned int index) {         \
        unsigned int count;                                                                        \
        Child last;                                                                                \
        RTU_CHECK_ERROR(rt##Name##GetChildCount(parent, &count));                                  \
        if (index >= count)                                                                        \
            return RT_ERROR_INVALID_VALUE;                                                         \
        RTU_CHECK_ERROR(rt##Name##GetChild(parent, count - 1, &last));                             \
        RTU_CHECK_ERROR(rt##Name##SetChild(parent, index, last));                                  \
        return rt##Name##SetChildCount(parent, count - 1);                                         \
    }                                                                                              \
    RTU_INLINE RTresult rtu##Name##RemoveChild(Parent parent, Child child) {                       \
        unsigned int index;                                                                        \
        RTU_CHECK_ERROR(rtu##Name##GetChildIndex(parent, child, &index));                          \
        return rtu##Name##RemoveChildByIndex(parent, index);                                       \
    }
SUNSTONE_RTU_CHILDREN(Group, RTgroup, RTobject)
SUNSTONE_RTU_CHILDREN(Selector, RTselector, RTobject)
SUNSTONE_RTU_CHILDREN(GeometryGroup, RTgeometrygroup, RTgeometryinstance)
#undef SUNSTONE_RTU_CHILDREN

RTU_INLINE RTresult rtuTransformSetChild(RTtransform transform, RTobject child) {
    return rtTransformSetChild(transform, child);
}
RTU_INLINE RTresult rtuTransformGetChild(RTtransform transform, RTobject* type) {
    return rtTransformGetChild(transform, type);
}
RTU_INLINE RTresult rtuTransformGetChildType(RTtransform transform, RTobjecttype* type) {
    return rtTransformGetChildType(transform, type);
}

#endif
