// SPDX-License-Identifier: Apache-2.0
// Calls the library that it is linked to: the classic API, OptiX Prime or sunstone/rays.h.
#include <cstdio>

#if defined(CONSUMER_CLASSIC)
#include <optix_world.h>
static int version() {
    unsigned number = 0;
    return rtGetVersion(&number) == RT_SUCCESS ? int(number) : -1;
}
#elif defined(CONSUMER_PRIME)
#include <optix_prime/optix_prime.h>
static int version() {
    unsigned number = 0;
    return rtpGetVersion(&number) == RTP_SUCCESS ? int(number) : -1;
}
#else
#include <sunstone/rays.h>
static int version() {
    return sunstoneSceneDestroy(nullptr) == SUNSTONE_INVALID_VALUE ? 1 : -1;
}
#endif

int main() {
    std::printf("version %d\n", version());
    return version() > 0 ? 0 : 1;
}
