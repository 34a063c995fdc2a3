// SPDX-License-Identifier: Apache-2.0
// See ptx_parts.h.
#include "device/cuda/ptx_parts.h"

#include "base/log.h"
#include "base/threads/threads.h"

#include <algorithm>
#include <array>
#include <map>
#include <unordered_set>

namespace sunstone::device::cuda {

namespace {

// The fewest functions called by address that justify a link, and the bytes of a part's text.
constexpr size_t kManyFunctions = 2, kPartBytes = 64 << 10;

bool isNamePart(char c) {
    return c == '_' || c == '$' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
           (c >= 'A' && c <= 'Z');
}

// The name is the word before the parameters; a function's results come first.
std::string_view nameIn(std::string_view head) {
    if (const size_t results = head.find(".func"); results != head.npos) {
        head.remove_prefix(results + 5);
        const size_t start = head.find_first_not_of(" \t\n");
        if (start != head.npos && head[start] == '(')
            head.remove_prefix(head.find(')') + 1);
    } else {
        head.remove_prefix(head.find(".entry") + 6);
    }
    const size_t first = size_t(std::find_if(head.begin(), head.end(), isNamePart) - head.begin());
    head.remove_prefix(first);
    return head.substr(
        0, size_t(std::find_if_not(head.begin(), head.end(), isNamePart) - head.begin()));
}

// Calls see(word, isCalled) for each word of a text. LLVM writes the name of a called function on a
// line of its own.
template <class See>
void forEachWord(std::string_view text, const See& see) {
    for (size_t at = 0; at < text.size();) {
        if (!isNamePart(text[at])) {
            ++at;
            continue;
        }
        size_t end = at;
        while (end < text.size() && isNamePart(text[end]))
            ++end;
        see(text.substr(at, end - at), at > 1 && text[at - 1] == '\t' && text[at - 2] == '\n' &&
                                           end < text.size() && text[end] == ',');
        at = end;
    }
}

// A variable of the module.
struct Variable {
    std::string_view line, name;
    bool isShared = false;
    std::vector<size_t> parts; // that use it
};

class Splitter {
public:
    explicit Splitter(std::string_view ptx) : pieces_(ptxPieces(ptx)) {
        for (size_t i = 0; i < pieces_.size(); ++i) {
            if (pieces_[i].isDefinition())
                definitions_.emplace(pieces_[i].name, i);
            else if (!pieces_[i].name.empty())
                declarations_.emplace(pieces_[i].name, i);
            else
                readVariables(pieces_[i].text);
        }
    }

    std::vector<std::string> split() {
        assign();
        if (numRoots_ < kManyFunctions || header_.empty() || !areLeaves())
            return {};
        std::vector<std::string> texts(parts_.size());
        for (Variable& variable : variables_) {
            for (size_t p = 0; p < parts_.size(); ++p)
                if (uses(p, variable.name))
                    variable.parts.push_back(p);
            if ((variable.isShared && variable.parts.size() > 1) || namesFunction(variable))
                return {};
        }
        for (size_t p = 0; p < parts_.size(); ++p)
            texts[p] = textOf(p);
        return texts;
    }

private:
    // Lines like ".global .align 4 .b8 name[16] = {...};", and the header.
    void readVariables(std::string_view text) {
        constexpr std::array<std::string_view, 4> kSpaces = {".global", ".const", ".shared",
                                                             ".local"};
        for (size_t at = 0; at < text.size();) {
            const std::string_view line = text.substr(at, text.find('\n', at) - at);
            at += line.size() + 1;
            const bool isVariable = std::ranges::any_of(kSpaces, [&](std::string_view space) {
                return line.find(space) != line.npos && line.starts_with('.');
            });
            if (isVariable) {
                std::string_view head = line.substr(0, line.find_first_of("=;"));
                head = head.substr(0, head.find('['));
                head = head.substr(0, head.find_last_not_of(' ') + 1);
                const size_t begin = head.find_last_of(" \t") + 1;
                variables_.push_back(
                    {line,
                     head.substr(begin),
                     line.find(".shared") != line.npos || line.find(".local") != line.npos,
                     {}});
            } else if (line.starts_with(".version") || line.starts_with(".target") ||
                       line.starts_with(".address_size")) {
                header_ += std::string(line) + "\n";
            }
        }
    }

    // Adds a function and its callees by name, except those that have a part already. Returns the
    // bytes of their texts.
    size_t add(size_t piece, size_t part) {
        std::vector<size_t> unread = {piece};
        size_t bytes = 0;
        while (!unread.empty()) {
            const size_t next = unread.back();
            unread.pop_back();
            if (!partOf_.emplace(next, part).second)
                continue;
            parts_[part].push_back(next);
            bytes += pieces_[next].text.size();
            forEachWord(pieces_[next].text, [&](std::string_view word, bool isCalled) {
                const auto definition = isCalled ? definitions_.find(word) : definitions_.end();
                if (definition != definitions_.end())
                    unread.push_back(definition->second);
            });
        }
        return bytes;
    }

    void assign() {
        parts_.emplace_back();
        for (size_t i = 0; i < pieces_.size(); ++i)
            if (pieces_[i].isKernel)
                add(i, 0);
        size_t bytes = kPartBytes;
        for (size_t i = 0; i < pieces_.size(); ++i) {
            if (!pieces_[i].isDefinition() || partOf_.contains(i))
                continue;
            ++numRoots_;
            if (bytes >= kPartBytes) {
                parts_.emplace_back();
                bytes = 0;
            }
            bytes += add(i, parts_.size() - 1);
        }
        words_.resize(parts_.size());
        for (size_t p = 0; p < parts_.size(); ++p) {
            std::ranges::sort(parts_[p]);
            for (const size_t piece : parts_[p])
                forEachWord(pieces_[piece].text,
                            [&](std::string_view word, bool) { words_[p].insert(word); });
        }
    }

    // Whether the functions called by address call none by address and none of the driver's. The
    // linker computes a kernel's stack from the calls that it sees, and the driver gives a linked
    // kernel no more.
    bool areLeaves() const {
        for (size_t p = 1; p < parts_.size(); ++p)
            for (const auto& [name, piece] : declarations_)
                if (!definitions_.contains(name) && uses(p, name))
                    return false;
        return std::ranges::none_of(definitions_, [&](const auto& each) {
            const PtxPiece& piece = pieces_[each.second];
            return !piece.isKernel && piece.text.find(".callprototype") != piece.text.npos;
        });
    }

    // Whether the variable starts with the address of a function, as tables of virtual functions
    // do. The linker may then not know the kernel's callees.
    bool namesFunction(const Variable& variable) const {
        bool found = false;
        forEachWord(variable.line,
                    [&](std::string_view word, bool) { found |= definitions_.contains(word); });
        return found;
    }

    bool uses(size_t part, std::string_view name) const { return words_[part].contains(name); }

    static std::string visible(std::string_view text) {
        return (text.starts_with(".visible") ? "" : ".visible ") + std::string(text);
    }
    // Turns a definition into a declaration.
    static std::string declared(std::string_view linkage, std::string_view text) {
        constexpr std::string_view kVisible = ".visible ";
        if (text.starts_with(kVisible))
            text.remove_prefix(kVisible.size());
        return std::string(linkage) + std::string(text.substr(0, text.find('{'))) + ";\n";
    }
    static std::string variableIn(const Variable& variable, size_t part) {
        if (variable.parts.size() < 2)
            return std::string(variable.line) + "\n";
        if (variable.parts.front() == part)
            return visible(variable.line) + "\n";
        constexpr std::string_view kVisible = ".visible ";
        std::string_view line = variable.line;
        if (line.starts_with(kVisible))
            line.remove_prefix(kVisible.size());
        line = line.substr(0, line.find_first_of("=;"));
        return ".extern " + std::string(line) + ";\n";
    }

    std::string textOf(size_t part) const {
        std::string text = header_ + "\n";
        for (const auto& [name, piece] : declarations_)
            if (!definitions_.contains(name) && uses(part, name))
                text += std::string(pieces_[piece].text) + "\n";
        for (const auto& [name, piece] : definitions_) {
            if (pieces_[piece].isKernel)
                continue;
            if (partOf_.at(piece) == part)
                text += declared(".visible ", pieces_[piece].text);
            else if (uses(part, name))
                text += declared(".extern ", pieces_[piece].text);
        }
        for (const Variable& variable : variables_)
            if (uses(part, variable.name))
                text += variableIn(variable, part);
        for (const size_t piece : parts_[part])
            text += visible(pieces_[piece].text) + "\n";
        return text;
    }

    std::vector<PtxPiece> pieces_;
    std::string header_;
    std::vector<Variable> variables_;
    std::map<std::string_view, size_t> definitions_, declarations_; // numbers of pieces
    std::map<size_t, size_t> partOf_;
    std::vector<std::vector<size_t>> parts_;
    std::vector<std::unordered_set<std::string_view>> words_; // of each part
    size_t numRoots_ = 0;
};

// Destroys a link at the end of its scope.
struct Link {
    const Driver& driver;
    CUlinkState state = nullptr;
    ~Link() {
        if (state)
            driver.linkDestroy(state);
    }
};

} // namespace

std::vector<PtxPiece> ptxPieces(std::string_view ptx) {
    std::vector<PtxPiece> pieces;
    size_t begin = 0, at = 0;
    while (at < ptx.size()) {
        const std::string_view line = ptx.substr(at, ptx.find('\n', at) - at);
        const bool isKernel = line.starts_with('.') && line.find(".entry") != line.npos;
        const bool isStart = isKernel || (line.starts_with('.') && line.find(".func") != line.npos);
        const size_t body = isStart ? ptx.find_first_of("{;", at) : ptx.npos;
        if (body == ptx.npos) {
            at += line.size() + 1;
            continue;
        }
        // A body ends with a brace in the first column.
        const size_t brace = ptx[body] == ';' ? body - 1 : ptx.find("\n}", body);
        const size_t end = brace == ptx.npos ? ptx.size() : brace + 2;
        pieces.push_back({ptx.substr(begin, at - begin), {}});
        pieces.push_back({ptx.substr(at, end - at), nameIn(ptx.substr(at, body - at)), isKernel});
        begin = at = end;
    }
    pieces.push_back({ptx.substr(begin), {}});
    return pieces;
}

std::vector<std::string> splitPtx(std::string_view ptx) {
    return Splitter(ptx).split();
}

std::optional<std::string> linkParts(const Driver& driver, const std::vector<LinkPart>& parts) {
    std::string errors(4096, '\0');
    CUjit_option options[] = {CU_JIT_ERROR_LOG_BUFFER, CU_JIT_ERROR_LOG_BUFFER_SIZE_BYTES};
    void* values[] = {errors.data(), reinterpret_cast<void*>(errors.size())};
    Link made{driver};
    void* code = nullptr;
    size_t size = 0;
    bool isGood = driver.linkCreate(unsigned(std::size(options)), options, values, &made.state) ==
                  CUDA_SUCCESS;
    for (const LinkPart& part : parts) { // the zero at the end of a text counts
        const size_t bytes = part.bytes.size() + (part.type == CU_JIT_INPUT_PTX ? 1 : 0);
        isGood = isGood &&
                 driver.linkAddData(made.state, part.type, const_cast<char*>(part.bytes.c_str()),
                                    bytes, nullptr, 0, nullptr, nullptr) == CUDA_SUCCESS;
    }
    if (isGood && driver.linkComplete(made.state, &code, &size) == CUDA_SUCCESS && size != 0)
        return std::string(static_cast<const char*>(code), size);
    log(LogLevel::kDebug, "device",
        message("the driver does not link ", parts.size(), " parts: ", errors.c_str()));
    return {};
}

std::optional<MachineCode> compileParts(const Driver& driver, const std::vector<std::string>& parts,
                                        unsigned computeCapability, unsigned maxRegisters) {
    std::vector<std::optional<MachineCode>> made(parts.size());
    parallelFor(parts.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            made[i] = compilePtx(parts[i], computeCapability, maxRegisters, PtxUse::kPart);
    });
    std::vector<LinkPart> codes;
    MachineCode all;
    for (const std::optional<MachineCode>& each : made) {
        if (!each)
            return {};
        all.log += each->log;
        codes.push_back({CU_JIT_INPUT_CUBIN, each->cubin});
    }
    std::optional<std::string> cubin = linkParts(driver, codes);
    if (!cubin)
        return {};
    all.cubin = std::move(*cubin);
    return all;
}

} // namespace sunstone::device::cuda
