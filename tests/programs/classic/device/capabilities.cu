// SPDX-License-Identifier: Apache-2.0
#include <optix.h>

rtDeclareVariable(unsigned int, launch_index, rtLaunchIndex, );
rtBuffer<unsigned int, 1> numbers;

RT_PROGRAM void fill() {
    numbers[launch_index] = launch_index * launch_index + 1u;
}
