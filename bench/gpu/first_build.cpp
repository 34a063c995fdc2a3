// SPDX-License-Identifier: Apache-2.0
// Latency of a process's first structures: from the creation of a device context on the existing
// CUDA context, through sizes and builds, to the end of the work on the stream. It includes
// compiling or loading the library's builders. There are few primitives, so that the builds
// themselves take little time. The environment gives the folder of OptiX's disk cache, because the
// context may need it at creation; the driver's own cache is as in compile.cpp.
#include "benches.h"
#include "world.h"

#include <chrono>
#include <cstdlib>

namespace bench {

void benchFirstBuild(const std::string& name, bool moves, const Settings& settings,
                     Measurements& measurements) {
    if (settings.cache.empty())
        setenv("OPTIX_CACHE_MAXSIZE", "0", 1);
    else
        setenv("OPTIX_CACHE_PATH", settings.cache.c_str(), 1);
    const World world = makeWorld(worldNames()[moves ? 9 : 0], 0.005);
    CUDA_CHECK(cudaFree(nullptr)); // makes the device's CUDA context current
    const auto start = std::chrono::steady_clock::now();
    const OptixDeviceContext context = createContext();
    {
        DeviceWorld device(context, world); // builds the instanced structures
        const Built built = device.build(world.buildFlags, 1);
        CUDA_CHECK(cudaDeviceSynchronize());
        const std::chrono::duration<double, std::milli> time =
            std::chrono::steady_clock::now() - start;
        measurements.add("first build in a process",
                         (moves ? "moving instances, " : "triangles, ") + name, time.count(), "ms");
    }
    OPTIX_CHECK(optixDeviceContextDestroy(context));
}

} // namespace bench
