// SPDX-License-Identifier: Apache-2.0
// The outermost layer of the parser: the directives and items of a module. See parser_impl.h.
#include "ptx/parse/parser.h"

#include "ptx/input_kind.h"
#include "ptx/parse/parser_impl.h"
#include "ptx/verifier.h"

#include <algorithm>

namespace sunstone::ptx {

Parser::Parser(Module& module, Diagnostics& diagnostics, const OpcodeTable& opcodes)
    : module_(module), diagnostics_(diagnostics), opcodes_(opcodes),
      lexer_(module.text, diagnostics), scopes_(names_) {}

void Parser::fault(Location location, std::string text) {
    diagnostics_.error(location, std::move(text));
    expressionDepth_ = 0; // a fault may leave open expressions
    throw Fault{};
}

void Parser::unexpected(const char* wanted) {
    if (atEnd())
        fault(token_.location,
              std::string("the text ends where ") + wanted + " should follow: it may be truncated");
    std::string shown(token_.text);
    if (token_.kind == TokenKind::kDotWord)
        shown.insert(0, 1, '.');
    fault(token_.location, std::string("expected ") + wanted + ", found " + quoted(shown));
}

bool Parser::accept(char c) {
    if (!token_.is(c))
        return false;
    advance();
    return true;
}

void Parser::expect(char c, const char* where) {
    if (accept(c))
        return;
    const std::string wanted = std::string("'") + c + "' " + where;
    unexpected(wanted.c_str());
}

std::string_view Parser::expectName(const char* what) {
    if (token_.kind != TokenKind::kIdentifier)
        unexpected(what);
    const std::string_view name = token_.text;
    advance();
    return name;
}

uint64_t Parser::expectInteger(const char* what, uint64_t limit) {
    if (token_.kind != TokenKind::kInteger)
        unexpected(what);
    const uint64_t value = token_.bits;
    if (value > limit)
        fault(token_.location, std::string(what) + " " + std::to_string(value) +
                                   " is above the limit of " + std::to_string(limit));
    advance();
    return value;
}

// After a fault, skips past the next ';', or to a brace or the end.
void Parser::recover() {
    while (!atEnd() && !at(';') && !at('{') && !at('}'))
        advance();
    accept(';');
}

void Parser::parseModule() {
    advance();
    if (token_.kind == TokenKind::kEnd && !diagnostics_.failed()) {
        diagnostics_.error({}, "the PTX text is empty: no .version directive in it");
        return;
    }
    while (!atEnd() && !tooManyErrors()) {
        try {
            parseItem();
        } catch (const Fault&) {
            if (!sawVersion_)
                return; // not PTX at all: one message suffices
            recover();
            // After a faulty header, skip the whole body.
            size_t depth = 0;
            do {
                depth += at('{');
                depth -= at('}') && depth > 0;
                if (depth > 0 || at('}'))
                    advance();
            } while (depth > 0 && !atEnd());
        }
    }
    if (!sawVersion_ || !sawTarget_) {
        if (!diagnostics_.failed())
            diagnostics_.error(token_.location, sawVersion_ ? "no .target directive in the text"
                                                            : "no .version directive in the text");
        return;
    }
    indexModule();
    resolveModuleNames();
}

void Parser::parseItem() {
    if (accept(';'))
        return;
    if (!sawVersion_ && !token_.isDot("version"))
        fault(token_.location, "PTX begins with a .version directive; found " +
                                   quoted(token_.text) + ": this text is not PTX");
    if (token_.kind != TokenKind::kDotWord)
        unexpected("a directive");
    const std::string_view word = token_.text;
    if (word == "version")
        return parseVersion();
    if (word == "target")
        return parseTarget();
    requireHeader();
    if (word == "address_size")
        return parseAddressSize();
    if (word == "file")
        return parseFile();
    if (word == "loc")
        return parseLoc();
    if (word == "section")
        return parseSection();
    if (word == "pragma")
        return parsePragma();
    const Location location = token_.location;
    const Linkage linkage = parseLinkage();
    if (token_.isDot("alias"))
        return parseAlias();
    if (token_.isDot("entry") || token_.isDot("func")) {
        const bool isEntry = token_.text == "entry";
        advance();
        return parseFunction(linkage, isEntry);
    }
    Space space = Space::kNone;
    if (token_.kind == TokenKind::kDotWord && parseSpace(token_.text, space)) {
        // Before PTX 3, compilers declare the registers of calls here, even without calls.
        if (space == Space::kReg && module_.versionMajor < 3)
            return skipStatement();
        if (space == Space::kReg || space == Space::kParam || space == Space::kLocal)
            fault(token_.location, "." + std::string(token_.text) +
                                       " variables belong inside a function, not at module scope");
        const bool isTexture = token_.isDot("tex");
        advance();
        return parseModuleVariables(linkage, space, isTexture, location);
    }
    unknownDirective();
}

void Parser::skipStatement() {
    while (token_.kind != TokenKind::kEnd && !token_.is(';'))
        advance();
    expect(';', "after the declaration");
}

void Parser::requireHeader() {
    if (sawTarget_)
        return;
    diagnostics_.error(token_.location, "a .target directive must follow .version");
    sawTarget_ = true; // report a missing .target only once
}

void Parser::unknownDirective() {
    if (token_.kind != TokenKind::kDotWord)
        unexpected("a directive");
    Nearest nearest(token_.text);
    for (const char* word :
         {"version", "target", "address_size", "visible", "extern", "weak", "common", "entry",
          "func", "global", "const", "shared", "file", "section", "pragma", "alias"})
        nearest.offer(word);
    fault(token_.location,
          "unknown directive " + quoted("." + std::string(token_.text)) + nearest.hint("."));
}

void Parser::parseVersion() {
    const Location location = token_.location;
    advance();
    // The lexer reads "7.4" as a decimal number, so the two halves come from the spelling.
    if (token_.kind != TokenKind::kFloat64)
        unexpected("a version number like 7.4");
    const std::string_view text = token_.text;
    const size_t point = text.find('.');
    const auto digits = [](std::string_view part) {
        return !part.empty() && part.size() < 5 &&
               std::all_of(part.begin(), part.end(), [](char c) { return c >= '0' && c <= '9'; });
    };
    if (point == std::string_view::npos || !digits(text.substr(0, point)) ||
        !digits(text.substr(point + 1)))
        unexpected("a version number like 7.4");
    if (sawVersion_)
        fault(location, "a second .version directive");
    const auto number = [](std::string_view part) {
        unsigned value = 0;
        for (const char c : part)
            value = value * 10 + (c - '0');
        return value;
    };
    module_.versionMajor = number(text.substr(0, point));
    module_.versionMinor = number(text.substr(point + 1));
    sawVersion_ = true;
    advance();
}

void Parser::parseTarget() {
    advance();
    sawTarget_ = true;
    for (bool first = true; first || accept(','); first = false) {
        const Location location = token_.location;
        const std::string_view name = expectName("a target like sm_75");
        if (name.substr(0, 3) == "sm_") {
            if (!module_.target.empty() && module_.target != name)
                diagnostics_.error(location, "two targets in one module: " +
                                                 quoted(module_.target) + " and " + quoted(name));
            module_.target = name;
        } else if (first) {
            const bool compute = name.substr(0, 8) == "compute_";
            diagnostics_.error(
                location,
                "target " + quoted(name) + " is not one of the sm_... targets of PTX" +
                    (compute ? " (did you mean 'sm_" + std::string(name.substr(8)) + "'?)" : ""));
        } else {
            module_.targetOptions.push_back(name);
        }
    }
}

void Parser::parseAddressSize() {
    advance();
    const Location location = token_.location;
    const uint64_t size = expectInteger("an address size", ~0ull);
    if (size != 64)
        diagnostics_.error(location,
                           ".address_size " + std::to_string(size) +
                               " is not supported: only 64-bit PTX runs here (compile with -m64)");
    module_.addressSize = 64;
}

// .file index "name" [, timestamp, size]
void Parser::parseFile() {
    constexpr uint64_t kMaxFiles = 65535;
    advance();
    const uint64_t index = expectInteger("a file number", kMaxFiles);
    if (token_.kind != TokenKind::kString)
        unexpected("a file name in quotes");
    if (module_.files.size() <= index)
        module_.files.resize(index + 1);
    module_.files[index] = std::string(token_.text);
    advance();
    if (accept(',')) {
        expectInteger("a time stamp", ~0ull);
        expect(',', "and a file size");
        expectInteger("a file size", ~0ull);
    }
}

// .loc file line column [, function_name label[+offset], inlined_at file line column]
void Parser::parseLoc() {
    constexpr uint64_t kMax = 0xFFFFFFFF;
    advance();
    source_.file = static_cast<uint32_t>(expectInteger("a file number", kMax));
    source_.line = static_cast<uint32_t>(expectInteger("a line number", kMax));
    source_.column = static_cast<uint32_t>(expectInteger("a column number", kMax));
    while (accept(',')) {
        const std::string_view word = expectName("function_name or inlined_at");
        if (word == "function_name") {
            expectName("a label");
            if (accept('+'))
                expectInteger("an offset", kMax);
        } else if (word == "inlined_at") {
            for (int i = 0; i < 3; ++i)
                expectInteger("a file, line and column", kMax);
        } else {
            fault(token_.location, "unknown .loc attribute " + quoted(word));
        }
    }
}

// Debug information: kept as text.
void Parser::parseSection() {
    const Location location = token_.location;
    advance();
    Section section;
    section.name = token_.text;
    while (!at('{')) {
        if (atEnd() || at(';') || at('}'))
            unexpected("'{' of the .section");
        advance();
    }
    const char* begin = token_.text.data() + token_.text.size();
    while (!at('}')) {
        if (atEnd())
            fault(location, "this .section has no end: missing '}', the text may be truncated");
        advance();
    }
    section.text = {begin, size_t(token_.text.data() - begin)};
    module_.sections.push_back(section);
    advance();
}

void Parser::parsePragma() {
    advance();
    do {
        if (token_.kind != TokenKind::kString)
            unexpected("a pragma in quotes");
        advance();
    } while (accept(','));
    expect(';', "after the pragma");
}

void Parser::parseAlias() {
    advance();
    const Token name = token_;
    expectName("the alias");
    expect(',', "between the alias and its function");
    const Token target = token_;
    expectName("the aliased function");
    expect(';', "after the alias");
    module_.aliases.emplace_back(name.text, target.text);
    moduleUses_.push_back({names_.intern(target.text), target.location});
}

Linkage Parser::parseLinkage() {
    Linkage linkage = Linkage::kInternal;
    for (; token_.kind == TokenKind::kDotWord; advance()) {
        if (token_.text == "visible")
            linkage = Linkage::kVisible;
        else if (token_.text == "extern")
            linkage = Linkage::kExtern;
        else if (token_.text == "weak")
            linkage = Linkage::kWeak;
        else if (token_.text == "common")
            linkage = Linkage::kCommon;
        else
            break;
    }
    return linkage;
}

// A definition takes precedence over declarations.
void Parser::indexModule() {
    for (uint32_t i = 0; i < module_.functions.size(); ++i) {
        const auto [entry, added] = module_.functionIndex.emplace(module_.functions[i].name, i);
        if (!added && module_.functions[i].hasBody)
            entry->second = i;
    }
    for (uint32_t i = 0; i < module_.variables.size(); ++i) {
        const auto [entry, added] = module_.variableIndex.emplace(module_.variables[i].name, i);
        if (!added && module_.variables[i].linkage != Linkage::kExtern)
            entry->second = i;
    }
}

void Parser::hintModuleNames(Nearest& nearest) const {
    for (const Variable& variable : module_.variables)
        nearest.offer(variable.name);
    for (const Function& function : module_.functions)
        nearest.offer(function.name);
}

// Checks symbols last, because a module may use symbols before it declares them.
void Parser::resolveModuleNames() {
    moduleNames_.assign(names_.size(), 0);
    const auto mark = [&](std::string_view text) {
        const NameId name = names_.intern(text);
        if (name >= moduleNames_.size())
            moduleNames_.resize(name + 1);
        moduleNames_[name] = 1;
    };
    for (const Variable& variable : module_.variables)
        mark(variable.name);
    for (const Function& function : module_.functions)
        mark(function.name);
    for (const auto& alias : module_.aliases)
        mark(alias.first);
    for (const NameUse& use : moduleUses_) {
        if (use.name < moduleNames_.size() && moduleNames_[use.name])
            continue;
        if (tooManyErrors())
            return;
        Nearest nearest(names_.text(use.name));
        hintModuleNames(nearest);
        diagnostics_.error(use.location,
                           "undeclared name " + quoted(names_.text(use.name)) + nearest.hint());
        moduleNames_.resize(names_.size());
        moduleNames_[use.name] = 1; // report each name only once
    }
}

std::unique_ptr<Module> parse(std::string_view text, Diagnostics& diagnostics, const Judge& judge,
                              const OpcodeTable& opcodes) {
    const std::string notPtx = describeForeignInput(text);
    if (!notPtx.empty()) {
        diagnostics.error({}, notPtx);
        return nullptr;
    }
    auto module = std::make_unique<Module>();
    module->text = std::string(text.substr(0, text.find('\0')));
    Parser(*module, diagnostics, opcodes).parseModule();
    if (!diagnostics.failed())
        verify(*module, diagnostics, judge, opcodes);
    return diagnostics.failed() ? nullptr : std::move(module);
}

} // namespace sunstone::ptx
