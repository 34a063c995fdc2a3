// SPDX-License-Identifier: Apache-2.0
// Each library of the portable build contains libstdc++ (scripts/portable). Exceptions cross the
// libraries, so all of them use the counters and the list of caught exceptions of libsunstone: part
// of that library and of all that link it.
#include <cxxabi.h>

#ifdef sunstone_EXPORTS

extern "C" __cxxabiv1::__cxa_eh_globals* sunstone_exception_globals() {
    return __cxxabiv1::__cxa_get_globals();
}

#else

extern "C" __cxxabiv1::__cxa_eh_globals* sunstone_exception_globals();

namespace __cxxabiv1 {

// Replace those of the archive.
extern "C" __cxa_eh_globals* __cxa_get_globals() noexcept {
    return sunstone_exception_globals();
}

extern "C" __cxa_eh_globals* __cxa_get_globals_fast() noexcept {
    return sunstone_exception_globals();
}

} // namespace __cxxabiv1

#endif
