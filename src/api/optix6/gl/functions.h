// SPDX-License-Identifier: Apache-2.0
// The OpenGL functions that interoperation needs, looked up at run time because the library links
// no OpenGL. A thread with a current context has already loaded the library that owns it. Names
// without `gl` are OpenGL's; numbers are those of its enumerators.
#pragma once

#include <cstddef>

namespace sunstone::optix6::gl {

constexpr unsigned kVersion = 0x1F02;
constexpr unsigned kArrayBuffer = 0x8892, kArrayBufferBinding = 0x8894, kBufferSize = 0x8764,
                   kBufferMapped = 0x88BC, kBufferAccessFlags = 0x911F,
                   kBufferImmutableStorage = 0x821F, kBufferStorageFlags = 0x8220,
                   kCopyReadBuffer = 0x8F36, kCopyReadBufferBinding = 0x8F36, kStreamCopy = 0x88E2;
constexpr int kMapPersistentBit = 0x40, kDynamicStorageBit = 0x100;
constexpr unsigned kPixelPackBuffer = 0x88EB, kPixelPackBufferBinding = 0x88ED;
constexpr unsigned kReadFramebuffer = 0x8CA8, kReadFramebufferBinding = 0x8CAA,
                   kColorAttachment0 = 0x8CE0, kFramebufferComplete = 0x8CD5,
                   kRenderbuffer = 0x8D41;

// Member, result, parameters.
#define SUNSTONE_GL_FUNCTIONS(X)                                                                   \
    X(GetString, const unsigned char*, unsigned)                                                   \
    X(GetError, unsigned)                                                                          \
    X(GetIntegerv, void, unsigned, int*)                                                           \
    X(IsBuffer, unsigned char, unsigned)                                                           \
    X(BindBuffer, void, unsigned, unsigned)                                                        \
    X(GetBufferParameteriv, void, unsigned, unsigned, int*)                                        \
    X(GetBufferSubData, void, unsigned, ptrdiff_t, ptrdiff_t, void*)                               \
    X(BufferSubData, void, unsigned, ptrdiff_t, ptrdiff_t, const void*)                            \
    X(IsTexture, unsigned char, unsigned)                                                          \
    X(BindTexture, void, unsigned, unsigned)                                                       \
    X(GetTexLevelParameteriv, void, unsigned, int, unsigned, int*)                                 \
    X(GetTexImage, void, unsigned, int, unsigned, unsigned, void*)                                 \
    X(PixelStorei, void, unsigned, int)
// Functions of later versions; null if the context has none of them.
#define SUNSTONE_GL_LATER_FUNCTIONS(X)                                                             \
    X(GetBufferParameteri64v, void, unsigned, unsigned, long long*)                                \
    X(GenBuffers, void, int, unsigned*)                                                            \
    X(DeleteBuffers, void, int, const unsigned*)                                                   \
    X(BufferData, void, unsigned, ptrdiff_t, const void*, unsigned)                                \
    X(CopyBufferSubData, void, unsigned, unsigned, ptrdiff_t, ptrdiff_t, ptrdiff_t)                \
    X(IsRenderbuffer, unsigned char, unsigned)                                                     \
    X(BindRenderbuffer, void, unsigned, unsigned)                                                  \
    X(GetRenderbufferParameteriv, void, unsigned, unsigned, int*)                                  \
    X(GenFramebuffers, void, int, unsigned*)                                                       \
    X(DeleteFramebuffers, void, int, const unsigned*)                                              \
    X(BindFramebuffer, void, unsigned, unsigned)                                                   \
    X(FramebufferRenderbuffer, void, unsigned, unsigned, unsigned, unsigned)                       \
    X(CheckFramebufferStatus, unsigned, unsigned)                                                  \
    X(ReadBuffer, void, unsigned)                                                                  \
    X(ReadPixels, void, int, int, int, int, unsigned, unsigned, void*)

namespace detail {
template <class Result, class... Parameters>
struct Pointer {
    using type = Result (*)(Parameters...);
};
} // namespace detail

struct Functions {
#define SUNSTONE_MEMBER(name, ...) detail::Pointer<__VA_ARGS__>::type name = nullptr;
    SUNSTONE_GL_FUNCTIONS(SUNSTONE_MEMBER)
    SUNSTONE_GL_LATER_FUNCTIONS(SUNSTONE_MEMBER)
#undef SUNSTONE_MEMBER
    int version = 0; // 10 * major + minor

    int integer(unsigned name) const {
        int value = 0;
        GetIntegerv(name, &value);
        return value;
    }
};

// The functions of the context that is current in this thread. Throws Failure:
// RT_ERROR_NOT_SUPPORTED if the process has no OpenGL or only OpenGL ES, RT_ERROR_INVALID_VALUE if
// no context is current.
Functions current();

} // namespace sunstone::optix6::gl
