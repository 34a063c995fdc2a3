// SPDX-License-Identifier: Apache-2.0
// For the test gpu.hung_test, which expects the report of a test that hangs.
#include "fixture.h"

#include <unistd.h>

namespace tests::api {
namespace {

class ProcessEnd : public ApiTest {};

TEST_F(ProcessEnd, DISABLED_Hangs) {
    for (;;)
        pause();
}

} // namespace
} // namespace tests::api
