// SPDX-License-Identifier: Apache-2.0
// Collected messages about a PTX text, and the search for the name closest to a misspelt one.
#include "ptx/diagnostics.h"

#include <algorithm>

namespace sunstone::ptx {
namespace {

constexpr size_t kMaxWarnings = 100;

const char* word(Severity severity) {
    switch (severity) {
    case Severity::kError:
        return "error: ";
    case Severity::kWarning:
        return "warning: ";
    case Severity::kNote:
        break;
    }
    return "note: ";
}

void append(std::string& text, const Diagnostic& diagnostic) {
    text += word(diagnostic.severity);
    if (diagnostic.location.line)
        text += "line " + std::to_string(diagnostic.location.line) + ":" +
                std::to_string(diagnostic.location.column) + ": ";
    text += diagnostic.text;
    text += '\n';
}

// The edit distance, in which a swap of neighbours counts once; stops above `limit`.
size_t distance(std::string_view a, std::string_view b, size_t limit) {
    if (a.size() > b.size() + limit || b.size() > a.size() + limit)
        return limit + 1;
    std::vector<size_t> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); ++j)
        above[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        row[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            const size_t change = above[j - 1] + (a[i - 1] != b[j - 1]);
            row[j] = std::min({change, above[j] + 1, row[j - 1] + 1});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before[j - 2] + 1);
        }
        std::swap(before, above);
        std::swap(above, row);
    }
    return above[b.size()];
}

} // namespace

void Diagnostics::error(Location location, std::string text) {
    if (++errors_ <= kMaxErrors)
        list_.push_back({Severity::kError, location, std::move(text)});
}

void Diagnostics::keepErrors(size_t count) {
    for (; errors_ > count; --errors_)
        if (errors_ <= kMaxErrors)
            list_.erase(std::find_if(list_.rbegin(), list_.rend(),
                                     [](const Diagnostic& each) {
                                         return each.severity == Severity::kError;
                                     })
                            .base() -
                        1);
}

void Diagnostics::warning(Location location, std::string text) {
    if (list_.size() < kMaxErrors + kMaxWarnings)
        list_.push_back({Severity::kWarning, location, std::move(text)});
}

std::string Diagnostics::format() const {
    std::string text;
    for (const Diagnostic& diagnostic : list_)
        if (diagnostic.severity == Severity::kError)
            append(text, diagnostic);
    if (errors_ > kMaxErrors)
        text += "error: " + std::to_string(errors_ - kMaxErrors) + " more errors\n";
    for (const Diagnostic& diagnostic : list_)
        if (diagnostic.severity != Severity::kError)
            append(text, diagnostic);
    return text;
}

void Nearest::offer(std::string_view candidate) {
    // Limits the time for hints: longer names and lists get no hint.
    constexpr size_t kMaxLength = 100, kMaxCandidates = 4000;
    if (name_.size() < 2 || name_.size() > kMaxLength || candidate.size() > kMaxLength ||
        ++offered_ > kMaxCandidates || candidate == name_)
        return;
    const size_t limit = std::min(best_ - 1, std::max<size_t>(1, name_.size() / 3));
    const size_t d = distance(name_, candidate, limit);
    if (d <= limit) {
        best_ = d;
        found_ = candidate;
    }
}

std::string Nearest::hint(const char* prefix) const {
    return found_.empty() ? std::string()
                          : " (did you mean '" + std::string(prefix) + found_ + "'?)";
}

std::string quoted(std::string_view text) {
    constexpr size_t kMaxShown = 60;
    std::string result = "'";
    for (const char c : text.substr(0, kMaxShown))
        result += c >= 32 && c < 127 ? c : '?';
    result += text.size() > kMaxShown ? "...'" : "'";
    return result;
}

} // namespace sunstone::ptx
