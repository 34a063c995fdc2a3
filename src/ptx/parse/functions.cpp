// SPDX-License-Identifier: Apache-2.0
// Function headers: results, name, parameters, performance directives; prototypes of indirect
// calls. See parser_impl.h; bodies are in bodies.cpp.
#include "ptx/parse/parser_impl.h"

namespace sunstone::ptx {

// ( param {, param} )
std::vector<Variable> Parser::parseParameters(bool prototype) {
    std::vector<Variable> parameters;
    expect('(', "of the parameter list");
    if (accept(')'))
        return parameters;
    do
        parameters.push_back(parseParameter(prototype));
    while (accept(','));
    expect(')', "after the parameters");
    return parameters;
}

Variable Parser::parseParameter(bool prototype) {
    Variable parameter;
    parameter.location = token_.location;
    if (token_.kind != TokenKind::kDotWord || !parseSpace(token_.text, parameter.space) ||
        (parameter.space != Space::kParam && parameter.space != Space::kReg))
        unexpected(".param or .reg");
    advance();
    parseVariableType(parameter);
    if (prototype && token_.kind != TokenKind::kIdentifier) {
        finishSize(parameter); // the '_' may be left out
        return parameter;
    }
    parameter.location = token_.location;
    parameter.name = expectName("a parameter name");
    parseDimensions(parameter);
    finishSize(parameter);
    return parameter;
}

void Parser::parseTriple(uint32_t (&values)[3]) {
    values[0] = values[1] = values[2] = 1;
    for (int i = 0; i < 3; ++i) {
        values[i] = static_cast<uint32_t>(expectInteger("a size", 0xFFFFFFFF));
        if (!accept(','))
            return;
    }
    unexpected("at most three sizes");
}

// Directives between the parameters and the body.
void Parser::parseFunctionAttributes(Function& function) {
    constexpr uint64_t kMax = 0xFFFFFFFF;
    while (token_.kind == TokenKind::kDotWord) {
        const std::string_view word = token_.text;
        if (word == "pragma") {
            parsePragma();
            continue;
        }
        if (word == "loc") {
            parseLoc();
            continue;
        }
        const Location location = token_.location;
        advance();
        if (word == "noreturn")
            function.noreturn = true;
        else if (word == "maxntid")
            parseTriple(function.maxThreads);
        else if (word == "reqntid")
            parseTriple(function.requiredThreads);
        else if (word == "minnctapersm")
            function.minBlocks = static_cast<uint32_t>(expectInteger("a number", kMax));
        else if (word == "maxnctapersm")
            function.maxBlocks = static_cast<uint32_t>(expectInteger("a number", kMax));
        else if (word == "maxnreg")
            function.maxRegisters = static_cast<uint32_t>(expectInteger("a number", kMax));
        else if (word == "reqnctapercluster")
            parseTriple(function.requiredCluster);
        else if (word == "maxclusterrank")
            function.maxClusterRank = static_cast<uint32_t>(expectInteger("a number", kMax));
        else if (word == "explicitcluster" || word == "blocksareclusters")
            function.explicitCluster = true;
        else if (word == "abi_preserve" || word == "abi_preserve_control")
            expectInteger("a number", kMax); // for the vendor's ABI; no effect here
        else if (word == "attribute") {
            Variable ignored; // .unified: for the vendor's linker
            parseAttribute(ignored);
        } else
            fault(location, "unknown function directive " + quoted("." + std::string(word)));
    }
}

// Parameters and results are the outermost scope of the body.
void Parser::declareParameters(std::vector<Variable>& variables, std::vector<uint32_t>& registers,
                               SymbolKind kind) {
    for (uint32_t i = 0; i < variables.size(); ++i) {
        const Variable& variable = variables[i];
        registers.push_back(~0u);
        if (variable.name == "_")
            continue;
        if (variable.space == Space::kReg) {
            registers.back() = static_cast<uint32_t>(function_.registers.size());
            Register pattern;
            pattern.type = variable.type;
            pattern.vector = variable.vector;
            pattern.location = variable.location;
            declareRegister(variable.name, pattern);
            continue;
        }
        const NameId name = names_.intern(variable.name);
        if (const auto earlier = scopes_.declare(name, {kind, i, variable.location}))
            fault(variable.location, "parameter " + quoted(variable.name) +
                                         " is declared twice; first at line " +
                                         std::to_string(earlier->location.line));
        uniqueName(variable.name, variableStamps_); // reserves the name: body variables with the
                                                    // same name are renamed
    }
}

namespace {

std::string counted(size_t count, const char* what) {
    return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

std::string shapeOf(const Variable& variable) {
    if (variable.isArray || variable.vector > 1)
        return "an array of " + counted(variable.size, "byte");
    return variable.type == Type::kPred ? "type .pred" : counted(variable.size, "byte");
}

std::string differenceOf(const std::vector<Variable>& here, const std::vector<Variable>& first,
                         const char* what) {
    if (here.size() != first.size())
        return counted(here.size(), what) + " here, " + std::to_string(first.size());
    for (size_t i = 0; i < here.size(); ++i)
        if (shapeOf(here[i]) != shapeOf(first[i]))
            return std::string(what) + " " + std::to_string(i + 1) + " of " + shapeOf(here[i]) +
                   " here, of " + shapeOf(first[i]);
    return {};
}

// The contradiction between two declarations of a function; "" if they agree. Types of one size
// agree, because compilers declare as .b32 a parameter that the definition declares as .f32.
std::string differenceOf(const Function& here, const Function& first) {
    if (here.isEntry != first.isEntry)
        return std::string(here.isEntry ? ".entry" : ".func") + " here, " +
               (first.isEntry ? ".entry" : ".func");
    const std::string results = differenceOf(here.results, first.results, "result");
    return results.empty() ? differenceOf(here.parameters, first.parameters, "parameter") : results;
}

} // namespace

void Parser::addFunction(Function&& function) {
    const auto variable = module_.variableIndex.find(function.name);
    if (variable != module_.variableIndex.end())
        fault(function.location,
              "function " + quoted(function.name) +
                  " has the name of a variable declared at line " +
                  std::to_string(module_.variables[variable->second].location.line));
    const uint32_t index = static_cast<uint32_t>(module_.functions.size());
    const auto [entry, added] = module_.functionIndex.emplace(function.name, index);
    if (!added) {
        const Function& first = module_.functions[entry->second];
        if (first.hasBody && function.hasBody)
            fault(function.location, "function " + quoted(function.name) +
                                         " is defined twice; first at line " +
                                         std::to_string(first.location.line));
        if (const std::string difference = differenceOf(function, first); !difference.empty())
            diagnostics_.error(function.location, "function " + quoted(function.name) + " has " +
                                                      difference + " at line " +
                                                      std::to_string(first.location.line));
        // Possibly only one of the declarations has .noreturn.
        module_.functions[entry->second].noreturn |= function.noreturn;
        function.noreturn = module_.functions[entry->second].noreturn;
        if (function.hasBody)
            entry->second = index;
    }
    module_.functions.push_back(std::move(function));
}

// After .entry or .func: [attributes] [(results)] name [(parameters)] [directives]
void Parser::parseHeader(Function& function) {
    parseFunctionAttributes(function);
    if (at('(')) {
        if (function.isEntry)
            fault(token_.location, "an .entry function has no results");
        function.results = parseParameters(false);
    }
    function.location = token_.location;
    function.name = expectName("a function name");
    if (at('('))
        function.parameters = parseParameters(false);
    parseFunctionAttributes(function);
    if (function.isEntry) {
        for (const Variable& parameter : function.parameters)
            if (parameter.space != Space::kParam)
                fault(parameter.location, "parameters of an .entry function must be .param");
    }
}

// After .entry or .func: a header, then a body or ';'
void Parser::parseFunction(Linkage linkage, bool isEntry) {
    function_ = Function();
    source_ = SourcePosition();
    ++functionNumber_;
    scopes_.beginFunction();
    function_.linkage = linkage;
    function_.isEntry = isEntry;
    parseHeader(function_);
    if (accept(';'))
        return addFunction(std::move(function_));
    if (!at('{'))
        unexpected("'{' of the function body, or ';'");
    function_.hasBody = true;
    scopes_.open();
    declareParameters(function_.results, function_.resultRegisters, SymbolKind::kResult);
    declareParameters(function_.parameters, function_.parameterRegisters, SymbolKind::kParameter);
    parseBody();
    addFunction(std::move(function_));
}

// After .func inside a body: the declaration of a function of the module.
void Parser::parseBodyFunction(Linkage linkage) {
    Function function;
    function.linkage = linkage;
    parseHeader(function);
    if (at('{'))
        fault(function.location, "function " + quoted(function.name) +
                                     " is defined in the body of function " +
                                     quoted(function_.name) + ": a '}' may be missing before it");
    expect(';', "after the declaration of a function");
    addFunction(std::move(function));
}

// After the label: .callprototype [(results)] _ (parameters) [.noreturn] ;
void Parser::parsePrototype(Prototype& prototype) {
    if (at('('))
        prototype.results = parseParameters(true);
    expectName("'_' in the place of the function's name");
    if (at('('))
        prototype.parameters = parseParameters(true);
    while (token_.kind == TokenKind::kDotWord) {
        const bool counted = token_.text == "abi_preserve" || token_.text == "abi_preserve_control";
        if (!counted && token_.text != "noreturn")
            unexpected("';' after the prototype");
        advance();
        if (counted)
            expectInteger("a number", 0xFFFFFFFF);
    }
    expect(';', "after the prototype");
}

} // namespace sunstone::ptx
