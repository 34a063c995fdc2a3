// SPDX-License-Identifier: Apache-2.0
// A flavor is a kind of device code: CUDA kernels, or the programs of one generation of the ray
// tracing API. It supplies the intrinsics, functions without a body that the code may call, and their
// lowering. A new generation adds a flavor in a folder of its own; compiler/optix7 is the example,
// docs/generations.md the overview.
#pragma once

#include "compiler/compiler.h"

#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace llvm {
class Function;
}

namespace sunstone::compiler {

class Unit;

// Bits of Intrinsic::kinds are 1 << ProgramKind.
constexpr uint32_t kindBit(ProgramKind kind) {
    return 1u << unsigned(kind);
}

struct Intrinsic {
    std::string name; // without the flavor's prefix
    unsigned op;      // the flavor's own number of the lowering
    int number = 0;   // a parameter of `op`
    std::string results; // one letter each: r 32 bits, l 64 bits, f float, p address
    std::string operands;
    uint32_t kinds = ~0u;      // program kinds that may reach it
    bool reads = false;        // only reads program state: calls may be merged or dropped
    bool anySignature = false; // operands are not checked
    bool isAvailable = true;   // false: known, and refused with kNotSupported
    bool namesLine = false;    // its lowering needs the place of the call in the source
};

using ProgramKinds = std::map<llvm::Function*, ProgramKind>;
using ProgramPayloads = std::map<llvm::Function*, const PayloadType*>;

class Flavor {
public:
    virtual ~Flavor() = default;
    virtual const char* name() const = 0; // part of the keys of compiled code

    // CUDA kernels. Everything else is programs that get a RayState.
    virtual bool isKernels() const { return false; }

    // Whether calls of this function are intrinsics, and what the intrinsic is; null: an unknown one.
    virtual bool isIntrinsicName(std::string_view name) const = 0;
    virtual const Intrinsic* find(std::string_view name) const = 0;
    // The intrinsics for a component ('x', 'y', 'z') of the launch index and dimensions, which code
    // reads as %tid and %ntid.
    virtual std::string launchIndex(char component) const = 0;
    virtual std::string launchDimension(char component) const = 0;

    // Whether modules share their functions and variables. If not, each module is complete by
    // itself, and several modules may use one name.
    virtual bool linksModules() const { return true; }
    // Whether a function of this name is a program, so that modules may use the name twice.
    virtual bool isProgramName(std::string_view name) const = 0;
    // Offset in RayState of the value of a program's parameter, one of `count`. None: such programs
    // have no such parameter.
    virtual std::optional<size_t> parameterAt(ProgramKind kind, size_t index,
                                              size_t count) const = 0;
    // For variables without a fixed address, because each program has its own values: the name of
    // an intrinsic without operands whose result (p) is the address. Empty for other variables.
    virtual std::string variableIntrinsic(const ptx::Module&, const ptx::Variable&) const {
        return {};
    }
    // Whether such variables may be in the thread's own memory although code addresses them as
    // global.
    virtual bool hasGlobalsOnStack() const { return false; }

    // Whether functions that call intrinsics, perhaps through others, may recurse. Such functions
    // are not inlined; markIntrinsicUsers marks them with kRecursive.
    virtual bool allowsRecursion() const { return false; }

    // Replaces the intrinsics of all programs (Unit::kinds) by loads, stores and calls on RayState.
    virtual void lower(Unit& unit, const ProgramPayloads& payloads) const = 0;
};

const Flavor& kernelFlavor();
const Flavor& optix6Flavor();
const Flavor& optix7Flavor();

// Metadata of loads in code for GPUs whose values stay the same while a program runs. The next
// launch index or ray reuses the memory, so the loads are not invariant in LLVM's sense.
constexpr const char* kStableLoad = "sunstone.stable";

// Attribute of functions that call themselves and an intrinsic, both perhaps through others.
constexpr const char* kRecursive = "sunstone-recursive";

// Marks functions that call an intrinsic, perhaps through others, for inlining into the programs
// that call them: an intrinsic may end the program, which is a return of the program itself. Throws
// Error(kInvalidPtx) on recursion through such functions, unless the flavor allows it.
void markIntrinsicUsers(Unit& unit);

} // namespace sunstone::compiler
