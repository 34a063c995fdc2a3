// SPDX-License-Identifier: Apache-2.0
// Channel descriptions of texel types: cudaCreateChannelDesc<float4>().
#ifndef SUNSTONE_CHANNEL_DESCRIPTOR_H
#define SUNSTONE_CHANNEL_DESCRIPTOR_H
#ifndef __CHANNEL_DESCRIPTOR_H__
#define __CHANNEL_DESCRIPTOR_H__ // disables a toolkit's header
#endif

#include "cuda_runtime_api.h"
#include "vector_types.h"

#ifdef __cplusplus

template <class T> static inline cudaChannelFormatDesc cudaCreateChannelDesc();
#define SUNSTONE_CHANNELS(T, bits, kind, stem)                                                     \
    template <> inline cudaChannelFormatDesc cudaCreateChannelDesc<T>() {                          \
        return ::cudaCreateChannelDesc(bits, 0, 0, 0, kind);                                       \
    }                                                                                              \
    template <> inline cudaChannelFormatDesc cudaCreateChannelDesc<stem##1>() {                    \
        return ::cudaCreateChannelDesc(bits, 0, 0, 0, kind);                                       \
    }                                                                                              \
    template <> inline cudaChannelFormatDesc cudaCreateChannelDesc<stem##2>() {                    \
        return ::cudaCreateChannelDesc(bits, bits, 0, 0, kind);                                    \
    }                                                                                              \
    template <> inline cudaChannelFormatDesc cudaCreateChannelDesc<stem##4>() {                    \
        return ::cudaCreateChannelDesc(bits, bits, bits, bits, kind);                              \
    }
SUNSTONE_CHANNELS(signed char, 8, cudaChannelFormatKindSigned, char)
SUNSTONE_CHANNELS(unsigned char, 8, cudaChannelFormatKindUnsigned, uchar)
SUNSTONE_CHANNELS(short, 16, cudaChannelFormatKindSigned, short)
SUNSTONE_CHANNELS(unsigned short, 16, cudaChannelFormatKindUnsigned, ushort)
SUNSTONE_CHANNELS(int, 32, cudaChannelFormatKindSigned, int)
SUNSTONE_CHANNELS(unsigned int, 32, cudaChannelFormatKindUnsigned, uint)
SUNSTONE_CHANNELS(float, 32, cudaChannelFormatKindFloat, float)
#undef SUNSTONE_CHANNELS
// 16-bit floats have functions instead, because their types are in another header.
static inline cudaChannelFormatDesc cudaCreateChannelDescHalf() {
    return ::cudaCreateChannelDesc(16, 0, 0, 0, cudaChannelFormatKindFloat);
}
static inline cudaChannelFormatDesc cudaCreateChannelDescHalf1() {
    return cudaCreateChannelDescHalf();
}
static inline cudaChannelFormatDesc cudaCreateChannelDescHalf2() {
    return ::cudaCreateChannelDesc(16, 16, 0, 0, cudaChannelFormatKindFloat);
}
static inline cudaChannelFormatDesc cudaCreateChannelDescHalf4() {
    return ::cudaCreateChannelDesc(16, 16, 16, 16, cudaChannelFormatKindFloat);
}
template <> inline cudaChannelFormatDesc cudaCreateChannelDesc<char>() {
    return ::cudaCreateChannelDesc(8, 0, 0, 0, cudaChannelFormatKindSigned);
}

#endif

#endif
