// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/wording.h"

namespace sunstone::optix7 {

const engine::Wording& wording();

} // namespace sunstone::optix7
