// SPDX-License-Identifier: Apache-2.0
// What the look-up of a callable gives a program in place of a code address. Programs look up a
// callable by `_optix_call_direct_callable(index)` and call what it returns through an ordinary
// indirect call. The callee also needs its SBT record, and the call is the only place to hand it
// over: between a look-up and its call a program may look up or call other callables, and PTX of
// other headers may merge look-ups of one index. So the look-up returns the index itself under a
// tag that no code address has, and each indirect call of an OptiX module asks the launch for code
// and record if its target carries the tag (resolveCallee in translate/control.cpp).
#pragma once

#include <cstdint>

namespace sunstone::compiler {

// index << kCallableIndexShift | continuation << 1 | kCallableTag. The tag is the lowest bit, as
// code starts at even addresses; the sign would do as well, but LLVM's folding of signed
// comparisons of addresses cannot be relied on.
constexpr uint64_t kCallableTag = 1;
constexpr uint64_t kContinuationTag = 2;
constexpr unsigned kCallableIndexShift = 2;
constexpr unsigned kFunctionAlignment = 16;

} // namespace sunstone::compiler
