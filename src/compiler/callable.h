// SPDX-License-Identifier: Apache-2.0
// What the look-up of a callable gives a program in place of a code address. Programs look up a
// callable by `_optix_call_direct_callable(index)` and call what it returns through an ordinary
// indirect call. The callee also needs its SBT record, and the call is the only place to hand it
// over: between a look-up and its call a program may look up or call other callables, and PTX of
// other headers may merge look-ups of one index. So the look-up returns the index itself under a
// tag that no code address has, and each indirect call of an OptiX module asks the launch for code
// and record if its target carries the tag (resolveCallee in translate_control.cpp).
#pragma once

#include <cstdint>

namespace sunstone::compiler {

constexpr uint64_t kCallableTag = 1ull << 63; // addresses of user space end at 2^57
constexpr uint64_t kContinuationTag = 1ull << 62;
constexpr unsigned kContinuationShift = 62;

} // namespace sunstone::compiler
