// SPDX-License-Identifier: Apache-2.0
// Scopes of a function body. See scopes.h.
#include "ptx/parse/scopes.h"

#include <charconv>

namespace sunstone::ptx {

Scopes::PerName& Scopes::of(NameId name) {
    if (name >= perName_.size())
        perName_.resize(names_.size() + names_.size() / 2 + 1);
    return perName_[name];
}

void Scopes::beginFunction() {
    entries_.clear();
    ranges_.clear();
    labels_.clear();
    uses_.clear();
    scopes_.clear();
    scopeCount_ = 0;
    innerRanges_ = 0;
}

void Scopes::open() {
    scopes_.push_back({scopeCount_++, uses_.size(), {}, {}, {}});
}

void Scopes::close(const Bind& bind) {
    const Scope& scope = scopes_.back();
    for (const uint32_t i : scope.labels) {
        const LabelEntry& label = labels_[i];
        PerName& name = of(label.declaration.name);
        while (name.use >= static_cast<int64_t>(scope.firstUse)) {
            LabelUse& use = uses_[name.use];
            use.bound = true;
            name.use = use.below;
            bind(use, label.declaration);
        }
        name.label = label.outer;
    }
    for (const uint32_t i : scope.entries)
        of(entries_[i].name).entry = entries_[i].outer;
    for (const uint32_t i : scope.ranges) {
        of(ranges_[i].prefix).range = ranges_[i].outer;
        innerRanges_ -= ranges_[i].depth > 2;
    }
    scopes_.pop_back();
}

std::vector<LabelUse> Scopes::endFunction(const Bind& bind) {
    while (!scopes_.empty())
        close(bind);
    std::vector<LabelUse> unbound;
    for (const LabelUse& use : uses_) {
        if (use.bound)
            continue;
        of(use.name).use = -1;
        unbound.push_back(use);
    }
    return unbound;
}

std::optional<Symbol> Scopes::declare(NameId name, const Symbol& symbol) {
    PerName& info = of(name);
    const uint32_t depth = static_cast<uint32_t>(scopes_.size());
    if (info.entry >= 0 && entries_[info.entry].depth == depth)
        return entries_[info.entry].symbol;
    scopes_.back().entries.push_back(static_cast<uint32_t>(entries_.size()));
    entries_.push_back({symbol, name, depth, info.entry});
    info.entry = static_cast<int64_t>(entries_.size()) - 1;
    return std::nullopt;
}

bool Scopes::declareRange(NameId prefix, const Register& pattern, uint32_t count) {
    PerName& info = of(prefix);
    const uint32_t depth = static_cast<uint32_t>(scopes_.size());
    if (info.range >= 0 && ranges_[info.range].depth == depth)
        return false;
    scopes_.back().ranges.push_back(static_cast<uint32_t>(ranges_.size()));
    ranges_.push_back({pattern, prefix, count, depth, info.range});
    info.range = static_cast<int64_t>(ranges_.size()) - 1;
    // Depth 1 has the parameters and depth 2 the body: a range there hides no used register.
    innerRanges_ += depth > 2;
    return true;
}

std::optional<Symbol> Scopes::find(NameId name, std::vector<Register>& registers) {
    const int64_t found = of(name).entry;
    if (found >= 0) {
        const Entry& entry = entries_[found];
        if (innerRanges_ == 0 || entry.depth == scopes_.size())
            return entry.symbol;
        const Symbol symbol = entry.symbol;
        const std::optional<Symbol> inner = expand(name, entry.depth, registers);
        return inner ? inner : symbol;
    }
    return expand(name, 0, registers);
}

// The register `name` of a range declared in a scope deeper than `aboveDepth`; creates it.
std::optional<Symbol> Scopes::expand(NameId name, uint32_t aboveDepth,
                                     std::vector<Register>& registers) {
    const std::string_view text = names_.text(name);
    size_t split = text.size(); // range numbers have ten digits at most
    while (split > 0 && text.size() - split < 10 && text[split - 1] >= '0' &&
           text[split - 1] <= '9')
        --split;
    for (; split < text.size(); ++split) {
        if (text[split] == '0' && split + 1 != text.size())
            continue; // numbers have no leading zeros
        uint32_t number = 0;
        const auto parsed =
            std::from_chars(text.data() + split, text.data() + text.size(), number, 10);
        if (parsed.ec != std::errc())
            continue;
        const NameId prefix = names_.intern(text.substr(0, split));
        int64_t found = of(prefix).range;
        while (found >= 0 && number >= ranges_[found].count)
            found = ranges_[found].outer;
        if (found < 0 || ranges_[found].depth <= aboveDepth)
            continue;
        const Range range = ranges_[found];
        const Symbol symbol = {SymbolKind::kRegister, static_cast<uint32_t>(registers.size()),
                               range.pattern.location};
        registers.push_back(range.pattern);
        registers.back().number = number;
        Scope& scope = scopes_[range.depth - 1];
        PerName& info = of(name);
        scope.entries.push_back(static_cast<uint32_t>(entries_.size()));
        entries_.push_back({symbol, name, range.depth, info.entry});
        info.entry = static_cast<int64_t>(entries_.size()) - 1;
        return symbol;
    }
    return std::nullopt;
}

std::optional<LabelDeclaration> Scopes::declareLabel(NameId name, LabelKind kind, uint32_t index,
                                                     Location location) {
    PerName& info = of(name);
    Scope& scope = scopes_.back();
    if (info.label >= 0 && labels_[info.label].declaration.scope == scope.number)
        return labels_[info.label].declaration;
    scope.labels.push_back(static_cast<uint32_t>(labels_.size()));
    labels_.push_back({{kind, index, name, location, scope.number}, info.label});
    info.label = static_cast<int64_t>(labels_.size()) - 1;
    return std::nullopt;
}

void Scopes::useLabel(LabelUse use) {
    PerName& info = of(use.name);
    use.below = info.use;
    info.use = static_cast<int64_t>(uses_.size());
    uses_.push_back(use);
}

void Scopes::forEachVisible(const std::function<void(std::string_view)>& fn) const {
    for (const Scope& scope : scopes_) {
        for (const uint32_t i : scope.entries)
            fn(names_.text(entries_[i].name));
    }
}

} // namespace sunstone::ptx
