// SPDX-License-Identifier: Apache-2.0
#include "api/optix6/gl/functions.h"

#include "api/optix6/object.h"

#include <cstdio>
#include <cstring>
#include <dlfcn.h>

namespace sunstone::optix6::gl {

namespace {

using Procedure = void (*)();
using Loader = Procedure (*)(const char*);

// Libraries that own contexts, with their functions for the current one and for addresses.
struct Owner {
    const char *library, *current, *loader;
};
constexpr Owner kOwners[] = {
    {"libEGL.so.1", "eglGetCurrentContext", "eglGetProcAddress"},
    {"libGLX.so.0", "glXGetCurrentContext", "glXGetProcAddressARB"},
    {"libGL.so.1", "glXGetCurrentContext", "glXGetProcAddressARB"},
    {"libOSMesa.so.8", "OSMesaGetCurrentContext", "OSMesaGetProcAddress"},
};

// No handle is kept: the library stays loaded as long as the application's handle.
void* symbolOf(const char* library, const char* name) {
    void* const handle = dlopen(library, RTLD_LAZY | RTLD_NOLOAD);
    if (!handle)
        return nullptr;
    void* const symbol = dlsym(handle, name);
    dlclose(handle);
    return symbol;
}

Loader loaderOfThread() {
    bool isLoaded = false;
    for (const Owner& owner : kOwners) {
        const auto context = reinterpret_cast<void* (*)()>(symbolOf(owner.library, owner.current));
        const auto loader = reinterpret_cast<Loader>(symbolOf(owner.library, owner.loader));
        isLoaded |= context && loader;
        if (context && loader && context())
            return loader;
    }
    if (!isLoaded)
        refuse(RT_ERROR_NOT_SUPPORTED, "the process has loaded no library of OpenGL: libEGL.so.1, "
                                       "libGLX.so.0, libGL.so.1 or libOSMesa.so.8");
    refuse(RT_ERROR_INVALID_VALUE, "no context of OpenGL is current in this thread");
}

template <class Pointer>
void load(Loader loader, const char* name, Pointer& pointer) {
    Procedure found = loader(name);
    // Loaders of old libraries only find extensions.
    for (const char* library : {"libOpenGL.so.0", "libGL.so.1"})
        if (!found)
            found = reinterpret_cast<Procedure>(symbolOf(library, name));
    pointer = reinterpret_cast<Pointer>(found);
}

template <class Pointer>
void require(Loader loader, const char* name, Pointer& pointer) {
    load(loader, name, pointer);
    if (!pointer)
        refuse(RT_ERROR_NOT_SUPPORTED, "the current context of OpenGL has no function ", name);
}

} // namespace

Functions current() {
    const Loader loader = loaderOfThread();
    Functions gl;
    require(loader, "glGetString", gl.GetString);
    const auto* text = reinterpret_cast<const char*>(gl.GetString(kVersion));
    int major = 0, minor = 0;
    if (!text || std::sscanf(text, "%d.%d", &major, &minor) != 2)
        refuse(RT_ERROR_NOT_SUPPORTED, "the current context is \"", text ? text : "",
               "\", but one of OpenGL is needed");
    gl.version = 10 * major + minor;
#define SUNSTONE_LOAD(name, ...) require(loader, "gl" #name, gl.name);
    SUNSTONE_GL_FUNCTIONS(SUNSTONE_LOAD)
#undef SUNSTONE_LOAD
#define SUNSTONE_LOAD(name, ...) load(loader, "gl" #name, gl.name);
    SUNSTONE_GL_LATER_FUNCTIONS(SUNSTONE_LOAD)
#undef SUNSTONE_LOAD
    return gl;
}

} // namespace sunstone::optix6::gl
