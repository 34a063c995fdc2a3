// SPDX-License-Identifier: Apache-2.0
#include "ptx/verifier.h"
namespace sunstone::ptx {
void verify(const Module&, Diagnostics&) {}
}
