// SPDX-License-Identifier: Apache-2.0
// Messages about a PTX text: collected, so that several faults are reported at once.
#pragma once

#include "ptx/ast.h"

#include <string>
#include <vector>

namespace sunstone::ptx {

enum class Severity : uint8_t { kError, kWarning, kNote };

struct Diagnostic {
    Severity severity = Severity::kError;
    Location location;
    std::string text;
};

class Diagnostics {
public:
    static constexpr size_t kMaxErrors = 20; // later ones are counted, not kept

    void error(Location location, std::string text);
    void warning(Location location, std::string text);
    bool failed() const { return errors_ != 0; }
    size_t errorCount() const { return errors_; }
    const std::vector<Diagnostic>& all() const { return list_; }
    // One line each, "error: line 12:5: text", errors first.
    std::string format() const;

private:
    std::vector<Diagnostic> list_;
    size_t errors_ = 0;
};

} // namespace sunstone::ptx
