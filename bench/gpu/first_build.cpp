// SPDX-License-Identifier: Apache-2.0
// What the first structures of a process wait for: a device context on the CUDA context that is
// there, sizes and builds, to the end of the work on the stream. A library has yet to make its
// builders, or to load them. Primitives are few, so that little of it is building. The folder of
// OptiX's disk cache is given by the environment, as the context may need it when it is made; the
// driver's own cache is as in compile.cpp.
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
        DeviceWorld device(context, world); // builds what instances show
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
