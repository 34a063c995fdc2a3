// SPDX-License-Identifier: Apache-2.0
// Names inside a function body, where braces open scopes.
//
// There are two name spaces. Symbols (registers, variables, parameters) are declared before use;
// labels (also of .callprototype, .branchtargets, .calltargets) may be used before. Each name has a
// chain of its declarations, innermost first, and each scope a list of its declarations, so closing
// a scope takes time proportional to its declarations. A label reference waits on its name's stack
// until a scope that declares the label closes. References from that scope are on top of the stack,
// because inner scopes have closed before, so binding is linear, too.
//
// The registers of a range (%r<100>) are created at their first use, so memory is bounded by the
// length of the text.
#pragma once

#include "ptx/ast.h"
#include "ptx/names.h"

#include <functional>
#include <optional>
#include <vector>

namespace sunstone::ptx {

enum class SymbolKind : uint8_t { kRegister, kVariable, kParameter, kResult };

struct Symbol {
    SymbolKind kind = SymbolKind::kRegister;
    uint32_t index = 0; // into the function's registers, variables, parameters or results
    Location location;
};

enum class LabelKind : uint8_t { kLabel, kPrototype, kBranchTargets, kCallTargets };

// A use of a label that waits for its declaration.
struct LabelUse {
    enum class Where : uint8_t { kOperand, kBranchTarget, kCallShape };
    Where where = Where::kOperand;
    uint32_t item = 0;    // statement, or index of the branch target list
    uint32_t element = 0; // operand, or entry of the list
    NameId name = 0;
    Location location;
    bool bound = false;
    int64_t below = -1; // next waiting use of the same name
};

struct LabelDeclaration {
    LabelKind kind = LabelKind::kLabel;
    uint32_t index = 0;
    NameId name = 0;
    Location location;
    uint32_t scope = 0; // number of the scope that declared it
};

class Scopes {
public:
    static constexpr size_t kMaxDepth = 1000;

    explicit Scopes(Names& names) : names_(names) {}

    using Bind = std::function<void(const LabelUse&, const LabelDeclaration&)>;

    void beginFunction();
    void open();
    // Closes the innermost scope and passes each label use that this resolves to `bind`.
    void close(const Bind& bind);
    size_t depth() const { return scopes_.size(); }
    // Closes the open scopes and returns the unresolved label uses, in order of the text.
    std::vector<LabelUse> endFunction(const Bind& bind);

    // Declares in the innermost scope. Returns the earlier symbol if the scope already has one.
    std::optional<Symbol> declare(NameId name, const Symbol& symbol);
    // Declares prefix0 ... prefix<count-1>; false if the scope has a range of this prefix.
    bool declareRange(NameId prefix, const Register& pattern, uint32_t count);
    // The meaning of `name` here. A register of a range is added to `registers` at its first use.
    std::optional<Symbol> find(NameId name, std::vector<Register>& registers);

    // Returns the earlier declaration if the scope already has one.
    std::optional<LabelDeclaration> declareLabel(NameId name, LabelKind kind, uint32_t index,
                                                 Location location);
    void useLabel(LabelUse use);

    // Calls fn with every visible symbol name and range prefix, for spelling hints.
    void forEachVisible(const std::function<void(std::string_view)>& fn) const;

private:
    struct Entry {
        Symbol symbol;
        NameId name;
        uint32_t depth;
        int64_t outer; // declaration of the same name that this one hides
    };
    struct Range {
        Register pattern;
        NameId prefix;
        uint32_t count;
        uint32_t depth;
        int64_t outer;
    };
    struct LabelEntry {
        LabelDeclaration declaration;
        int64_t outer;
    };
    struct Scope {
        uint32_t number;
        size_t firstUse;
        std::vector<uint32_t> entries, ranges, labels;
    };
    struct PerName {
        int64_t entry = -1, range = -1, label = -1, use = -1;
    };

    PerName& of(NameId name);
    std::optional<Symbol> expand(NameId name, uint32_t aboveDepth,
                                 std::vector<Register>& registers);

    Names& names_;
    std::vector<PerName> perName_;
    std::vector<Entry> entries_;
    std::vector<Range> ranges_;
    std::vector<LabelEntry> labels_;
    std::vector<LabelUse> uses_;
    std::vector<Scope> scopes_;
    uint32_t scopeCount_ = 0;
    size_t innerRanges_ = 0; // ranges declared below the body's outermost scope and still visible
};

} // namespace sunstone::ptx
