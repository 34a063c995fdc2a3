// SPDX-License-Identifier: Apache-2.0
// Table of special registers (PTX ISA manual, chapter on special registers).
#include "ptx/opcodes/special_registers.h"

#include <algorithm>
#include <iterator>

namespace sunstone::ptx {
namespace {

// Sorted by name.
constexpr SpecialRegister kSpecialRegisters[] = {
    {"%aggr_smem_size", Type::kU32, false},
    {"%clock", Type::kU32, false},
    {"%clock64", Type::kU64, false},
    {"%clock_hi", Type::kU32, false},
    {"%cluster_ctaid", Type::kU32, true},
    {"%cluster_ctarank", Type::kU32, false},
    {"%cluster_nctaid", Type::kU32, true},
    {"%cluster_nctarank", Type::kU32, false},
    {"%clusterid", Type::kU32, true},
    {"%ctaid", Type::kU32, true},
    {"%current_graph_exec", Type::kU64, false},
    {"%dynamic_smem_size", Type::kU32, false},
    {"%globaltimer", Type::kU64, false},
    {"%globaltimer_hi", Type::kU32, false},
    {"%globaltimer_lo", Type::kU32, false},
    {"%gridid", Type::kU64, false},
    {"%is_explicit_cluster", Type::kPred, false},
    {"%laneid", Type::kU32, false},
    {"%lanemask_eq", Type::kU32, false},
    {"%lanemask_ge", Type::kU32, false},
    {"%lanemask_gt", Type::kU32, false},
    {"%lanemask_le", Type::kU32, false},
    {"%lanemask_lt", Type::kU32, false},
    {"%nclusterid", Type::kU32, true},
    {"%nctaid", Type::kU32, true},
    {"%nsmid", Type::kU32, false},
    {"%ntid", Type::kU32, true},
    {"%nwarpid", Type::kU32, false},
    {"%reserved_smem_offset_begin", Type::kB32, false},
    {"%reserved_smem_offset_cap", Type::kB32, false},
    {"%reserved_smem_offset_end", Type::kB32, false},
    {"%smid", Type::kU32, false},
    {"%tid", Type::kU32, true},
    {"%total_smem_size", Type::kU32, false},
    {"%warpid", Type::kU32, false},
};

constexpr SpecialRegister kEnvironment = {"%envreg", Type::kB32, false};
constexpr SpecialRegister kCounter = {"%pm", Type::kU32, false};
constexpr SpecialRegister kWideCounter = {"%pm_64", Type::kU64, false};
constexpr SpecialRegister kReservedOffset = {"%reserved_smem_offset_", Type::kB32, false};

// The number after a prefix, or `limit` if the rest is not a number below it.
unsigned numberAfter(std::string_view text, size_t prefix, unsigned limit) {
    const std::string_view digits = text.substr(prefix);
    if (digits.empty() || digits.size() > 2 || (digits.size() == 2 && digits[0] == '0'))
        return limit;
    unsigned value = 0;
    for (const char c : digits) {
        if (c < '0' || c > '9')
            return limit;
        value = value * 10 + static_cast<unsigned>(c - '0');
    }
    return std::min(value, limit);
}

} // namespace

const SpecialRegister* findSpecialRegister(std::string_view name) {
    const auto found = std::lower_bound(
        std::begin(kSpecialRegisters), std::end(kSpecialRegisters), name,
        [](const SpecialRegister& entry, std::string_view key) { return entry.name < key; });
    if (found != std::end(kSpecialRegisters) && found->name == name)
        return found;
    if (name.substr(0, 7) == "%envreg")
        return numberAfter(name, 7, 32) < 32 ? &kEnvironment : nullptr;
    if (name.substr(0, 22) == "%reserved_smem_offset_")
        return numberAfter(name, 22, 2) < 2 ? &kReservedOffset : nullptr;
    if (name.substr(0, 3) != "%pm")
        return nullptr;
    if (name.size() > 6 && name.substr(name.size() - 3) == "_64")
        return numberAfter(name.substr(0, name.size() - 3), 3, 8) < 8 ? &kWideCounter : nullptr;
    return numberAfter(name, 3, 8) < 8 ? &kCounter : nullptr;
}

} // namespace sunstone::ptx
