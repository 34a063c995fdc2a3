// SPDX-License-Identifier: Apache-2.0
// The value that looking up a callable gives a program in place of a code address. Programs look up
// a callable with `_optix_call_direct_callable(index)` and call the result through an ordinary
// indirect call. The callee also needs its SBT record, which only the call can pass: between a
// look-up and its call a program may look up or call other callables, and PTX of other headers may
// merge look-ups of one index. So the look-up returns the index itself with a tag that no code
// address has, and each indirect call of an OptiX module asks the launch for code and record if its
// target has the tag (resolveCallee in translate/control.cpp).
#pragma once

#include <cstdint>

namespace sunstone::compiler {

// index << kCallableIndexShift | continuation << 1 | kCallableTag. The tag is the lowest bit, as
// code starts at even addresses. The sign bit would be free too, but LLVM's folding of signed
// address comparisons is unreliable.
constexpr uint64_t kCallableTag = 1;
constexpr uint64_t kContinuationTag = 2;
constexpr unsigned kCallableIndexShift = 2;
constexpr unsigned kFunctionAlignment = 16;

} // namespace sunstone::compiler
