// SPDX-License-Identifier: Apache-2.0
// Messages about a PTX text, collected so that several faults are reported at once.
#pragma once

#include "ptx/ast.h"

#include <string>
#include <string_view>
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
    static constexpr size_t kMaxErrors = 20; // further errors are only counted

    void error(Location location, std::string text);
    void warning(Location location, std::string text);
    // Removes the last errors, so that `count` errors remain.
    void keepErrors(size_t count);
    bool failed() const { return errors_ != 0; }
    size_t errorCount() const { return errors_; }
    const std::vector<Diagnostic>& all() const { return list_; }
    // One line each, "error: line 12:5: text", errors first.
    std::string format() const;

private:
    std::vector<Diagnostic> list_;
    size_t errors_ = 0;
};

// Finds the known name closest to a misspelt one: offer() the known names, then call hint().
class Nearest {
public:
    explicit Nearest(std::string_view name) : name_(name) {}
    void offer(std::string_view candidate);
    // " (did you mean 'x'?)", or empty if no name is close.
    std::string hint(const char* prefix = "") const;

private:
    std::string_view name_;
    std::string found_;
    size_t best_ = 4; // distances below this count as close
    size_t offered_ = 0;
};

// A piece of the text in quotes, shortened and with unprintable bytes replaced.
std::string quoted(std::string_view text);

} // namespace sunstone::ptx
