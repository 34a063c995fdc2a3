// SPDX-License-Identifier: Apache-2.0
// An OpenGL context without a window, through EGL loaded at run time, and the OpenGL functions that
// tests call. Numbers are those of the enumerators of EGL and OpenGL.
#pragma once

#include <cstddef>
#include <dlfcn.h>
#include <string>

namespace sunstone::api6 {

namespace enums {
constexpr unsigned kArrayBuffer = 0x8892, kCopyReadBuffer = 0x8F36, kPixelPackBuffer = 0x88EB,
                   kStaticDraw = 0x88E4, kWriteOnly = 0x88B9;
constexpr unsigned kTexture1D = 0x0DE0, kTexture2D = 0x0DE1, kTexture3D = 0x806F,
                   kRectangle = 0x84F5, kTexture1DArray = 0x8C18, kTexture2DArray = 0x8C1A,
                   kCube = 0x8513, kCubeFace0 = 0x8515, kCubeArray = 0x9009;
constexpr unsigned kRenderbuffer = 0x8D41, kFramebuffer = 0x8D40, kReadFramebuffer = 0x8CA8,
                   kColorAttachment0 = 0x8CE0, kColor = 0x1800;
constexpr unsigned kRed = 0x1903, kRg = 0x8227, kRgba = 0x1908, kRedInteger = 0x8D94,
                   kRgInteger = 0x8228, kRgbaInteger = 0x8D99, kDepthComponent = 0x1902;
constexpr unsigned kByte = 0x1400, kUnsignedByte = 0x1401, kShort = 0x1402, kUnsignedShort = 0x1403,
                   kInt = 0x1404, kUnsignedInt = 0x1405, kFloat = 0x1406;
constexpr int kR32F = 0x822E, kRgba32F = 0x8814, kRgba8 = 0x8058;
} // namespace enums

class Egl {
public:
    // Empty, or why there is no context.
    std::string reason;

    Egl() {
        library_ = dlopen("libEGL.so.1", RTLD_LAZY);
        if (!library_) {
            reason = "libEGL.so.1 is not installed";
            return;
        }
        find(getProcAddress_, "eglGetProcAddress");
        find(makeCurrent_, "eglMakeCurrent");
        find(createContext_, "eglCreateContext");
        reason = create();
    }
    Egl(const Egl&) = delete;

    bool makeCurrent() { return makeCurrent_(display_, nullptr, nullptr, context_) != 0; }
    void release() { makeCurrent_(display_, nullptr, nullptr, nullptr); }
    // A context of OpenGL ES in place of the one of OpenGL, until leaveEs().
    bool enterEs() {
        constexpr int kMajor = 0x3098, kNone = 0x3038;
        const int attributes[] = {kMajor, 3, kNone};
        release();
        void* const es = bindApi_(kOpenGlEsApi)
                             ? createContext_(display_, nullptr, nullptr, attributes)
                             : nullptr;
        return es && makeCurrent_(display_, nullptr, nullptr, es) != 0;
    }
    void leaveEs() {
        release();
        bindApi_(kOpenGlApi);
        makeCurrent();
    }

#define SUNSTONE_TEST_GL(X)                                                                        \
    X(GetString, const unsigned char*, unsigned)                                                   \
    X(GetError, unsigned)                                                                          \
    X(GetIntegerv, void, unsigned, int*)                                                           \
    X(GenBuffers, void, int, unsigned*)                                                            \
    X(DeleteBuffers, void, int, const unsigned*)                                                   \
    X(BindBuffer, void, unsigned, unsigned)                                                        \
    X(BufferData, void, unsigned, ptrdiff_t, const void*, unsigned)                                \
    X(BufferStorage, void, unsigned, ptrdiff_t, const void*, unsigned)                             \
    X(BufferSubData, void, unsigned, ptrdiff_t, ptrdiff_t, const void*)                            \
    X(GetBufferSubData, void, unsigned, ptrdiff_t, ptrdiff_t, void*)                               \
    X(MapBuffer, void*, unsigned, unsigned)                                                        \
    X(UnmapBuffer, unsigned char, unsigned)                                                        \
    X(GenTextures, void, int, unsigned*)                                                           \
    X(DeleteTextures, void, int, const unsigned*)                                                  \
    X(BindTexture, void, unsigned, unsigned)                                                       \
    X(TexImage1D, void, unsigned, int, int, int, int, unsigned, unsigned, const void*)             \
    X(TexImage2D, void, unsigned, int, int, int, int, int, unsigned, unsigned, const void*)        \
    X(TexImage3D, void, unsigned, int, int, int, int, int, int, unsigned, unsigned, const void*)   \
    X(PixelStorei, void, unsigned, int)                                                            \
    X(GenFramebuffers, void, int, unsigned*)                                                       \
    X(BindFramebuffer, void, unsigned, unsigned)                                                   \
    X(FramebufferRenderbuffer, void, unsigned, unsigned, unsigned, unsigned)                       \
    X(GenRenderbuffers, void, int, unsigned*)                                                      \
    X(BindRenderbuffer, void, unsigned, unsigned)                                                  \
    X(RenderbufferStorage, void, unsigned, unsigned, int, int)                                     \
    X(ClearBufferfv, void, unsigned, int, const float*)
    template <class Result, class... Parameters>
    struct Pointer {
        using type = Result (*)(Parameters...);
    };
#define SUNSTONE_MEMBER(name, ...) Pointer<__VA_ARGS__>::type name = nullptr;
    SUNSTONE_TEST_GL(SUNSTONE_MEMBER)
#undef SUNSTONE_MEMBER

    int integer(unsigned name) const {
        int value = -1;
        GetIntegerv(name, &value);
        return value;
    }

private:
    using Procedure = void (*)();
    template <class Function>
    void find(Function& function, const char* name) {
        function = reinterpret_cast<Function>(dlsym(library_, name));
    }

    std::string create() {
        constexpr unsigned kSurfaceless = 0x31DD;
        constexpr int kMajor = 0x3098, kMinor = 0x30FB, kProfile = 0x30FD, kCore = 1,
                      kNone = 0x3038;
        void* (*getPlatformDisplay)(unsigned, void*, const ptrdiff_t*) = nullptr;
        unsigned (*initialize)(void*, int*, int*) = nullptr;
        find(getPlatformDisplay, "eglGetPlatformDisplay");
        find(initialize, "eglInitialize");
        find(bindApi_, "eglBindAPI");
        if (!getPlatformDisplay || !initialize || !bindApi_ || !getProcAddress_)
            return "libEGL.so.1 is older than EGL 1.5";
        display_ = getPlatformDisplay(kSurfaceless, nullptr, nullptr);
        if (!display_ || !initialize(display_, nullptr, nullptr))
            return "EGL has no display without a surface";
        const int attributes[] = {kMajor, 4, kMinor, 5, kProfile, kCore, kNone};
        if (bindApi_(kOpenGlApi))
            context_ = createContext_(display_, nullptr, nullptr, attributes);
        if (!context_)
            return "EGL makes no context of OpenGL 4.5";
#define SUNSTONE_LOAD(name, ...)                                                                   \
    name = reinterpret_cast<decltype(name)>(getProcAddress_("gl" #name));                          \
    if (!name)                                                                                     \
        return "OpenGL has no function gl" #name;
        SUNSTONE_TEST_GL(SUNSTONE_LOAD)
#undef SUNSTONE_LOAD
        return {};
    }

    void *library_ = nullptr, *display_ = nullptr, *context_ = nullptr;
    static constexpr unsigned kOpenGlApi = 0x30A2, kOpenGlEsApi = 0x30A0;
    unsigned (*bindApi_)(unsigned) = nullptr;
    Procedure (*getProcAddress_)(const char*) = nullptr;
    unsigned (*makeCurrent_)(void*, void*, void*, void*) = nullptr;
    void* (*createContext_)(void*, void*, void*, const int*) = nullptr;
};

} // namespace sunstone::api6
