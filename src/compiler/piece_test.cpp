// SPDX-License-Identifier: Apache-2.0
// Pieces of pipelines: serialisation, keys, reuse from a store, variables shared by programs.
#include "compiler/piece.h"

#include "compiler/flavor.h"
#include "compiler/testing.h"

#include <map>
#include <mutex>

namespace sunstone::compiler::testing {
namespace {

class MapStore : public ObjectStore {
public:
    bool find(const std::string& key, std::string& value) override {
        std::lock_guard lock(mutex_);
        const auto found = values.find(key);
        if (found == values.end())
            return false;
        value = found->second;
        ++hits;
        return true;
    }
    void insert(const std::string& key, const std::string& value) override {
        std::lock_guard lock(mutex_);
        values[key] = value;
        ++inserts;
    }
    std::map<std::string, std::string> values;
    unsigned hits = 0, inserts = 0;

private:
    std::mutex mutex_;
};

using Module = std::shared_ptr<const Source>;

// Each program adds its step to `counter` and stores the sum at the address in the launch
// parameters.
std::string counterProgram(const char* name, unsigned step) {
    return std::string(".visible .entry ") + name +
           "() { .reg .b32 %r<3>; .reg .b64 %rd<3>;\n"
           "ld.global.u32 %r1, [counter]; add.u32 %r1, %r1, " +
           std::to_string(step) +
           "; st.global.u32 [counter], %r1;\n"
           "ld.const.u64 %rd1, [params]; st.global.u32 [%rd1], %r1; ret; }\n";
}
const std::string kParams = ".const .align 8 .b8 params[8];\n";
const std::string kCounter = ".global .align 4 .u32 counter = 100;\n";

ProgramRequest missOf(Module module, const char* name) {
    return {std::move(module), name, ProgramKind::kMiss};
}

struct Runner {
    explicit Runner(const std::vector<ProgramRequest>& programs, ObjectStore* store = nullptr) {
        PipelineRequest request;
        request.rules.launchParams = "params";
        request.programs = programs;
        code = compilePipeline(request, store);
    }
    uint32_t call(size_t program) {
        uint32_t result = 0;
        uint32_t* params[1] = {&result};
        devlib::LaunchState launch{};
        launch.params = reinterpret_cast<uint8_t*>(params);
        devlib::ThreadState thread{};
        devlib::RayState ray{};
        ray.launch = &launch;
        ray.thread = &thread;
        devlib::ProgramFn(const_cast<void*>(code->programs()[program].address))(&ray);
        return result;
    }
    std::unique_ptr<Code> code;
};

TEST(CodeObject, BytesAndBack) {
    CodeObject object;
    object.code = std::string("\0code\xff", 6);
    object.stackSizes = {{"a", 1}, {"b", 77}};
    object.variables = {{0, VariableId::kModuleScope, 3}, {1, 2, 0}};
    const std::string bytes = object.serialize();
    CodeObject again;
    ASSERT_TRUE(again.deserialize(bytes));
    EXPECT_EQ(object.code, again.code);
    EXPECT_EQ(object.stackSizes, again.stackSizes);
    EXPECT_EQ(object.variables, again.variables);
}

TEST(CodeObject, RefusesOtherBytes) {
    CodeObject object;
    object.code = "code";
    object.stackSizes = {{"a", 1}};
    object.variables = {{0, 0, 3}};
    const std::string bytes = object.serialize();
    CodeObject again;
    for (size_t size = 0; size < bytes.size(); ++size)
        EXPECT_FALSE(again.deserialize(std::string_view(bytes).substr(0, size))) << size;
    EXPECT_FALSE(again.deserialize(bytes + "x"));
    std::string huge = bytes;
    std::memset(huge.data() + 4, 0xff, 4); // a size far beyond the end
    EXPECT_FALSE(again.deserialize(huge));
    EXPECT_FALSE(again.deserialize(std::string(64, '\xff')));
}

TEST(Piece, ProgramsShareAVariable) {
    const Module module = source(kHeader + kParams + kCounter + counterProgram("__miss__a", 1) +
                                counterProgram("__miss__b", 10));
    Runner run({missOf(module, "__miss__a"), missOf(module, "__miss__b")});
    EXPECT_EQ(101u, run.call(0));
    EXPECT_EQ(111u, run.call(1));
    EXPECT_EQ(112u, run.call(0));
    void* address = nullptr;
    uint64_t size = 0;
    ASSERT_TRUE(run.code->variable("counter", &address, &size));
    EXPECT_EQ(4u, size);
    EXPECT_EQ(112u, *static_cast<uint32_t*>(address));
}

TEST(Piece, PrivateVariablesOfTwoModulesAreTwo) {
    const std::string text = kHeader + kParams + kCounter + counterProgram("__miss__a", 1);
    Runner run({missOf(source(text), "__miss__a"), missOf(source(text), "__miss__a")});
    EXPECT_EQ(101u, run.call(0));
    EXPECT_EQ(102u, run.call(0));
    EXPECT_EQ(101u, run.call(1));
}

TEST(Piece, AVariableOfAnotherModuleIsShared) {
    const Module owner = source(kHeader + kParams + ".visible " + kCounter +
                               counterProgram("__miss__a", 1));
    const Module user = source(kHeader + kParams + ".extern .global .align 4 .u32 counter;\n" +
                              counterProgram("__miss__b", 10));
    PipelineRules rules;
    rules.launchParams = "params";
    EXPECT_TRUE(isSelfContained(owner->tree(), rules));
    EXPECT_FALSE(isSelfContained(user->tree(), rules));
    Runner run({missOf(user, "__miss__b"), missOf(owner, "__miss__a")});
    EXPECT_EQ(110u, run.call(0));
    EXPECT_EQ(111u, run.call(1));
}

TEST(Piece, InitialisersHoldAddresses) {
    const Module module =
        source(kHeader + kParams + kCounter + ".global .align 8 .u64 pointer = counter;\n" +
              "\n.visible .entry __miss__a() { .reg .b32 %r<3>; .reg .b64 %rd<3>;\n"
              "ld.global.u64 %rd2, [pointer]; ld.global.u32 %r1, [%rd2];\n"
              "ld.const.u64 %rd1, [params]; st.global.u32 [%rd1], %r1; ret; }\n" +
              counterProgram("__miss__b", 5));
    Runner run({missOf(module, "__miss__a"), missOf(module, "__miss__b")});
    EXPECT_EQ(100u, run.call(0));
    EXPECT_EQ(105u, run.call(1));
    EXPECT_EQ(105u, run.call(0));
}

TEST(Piece, AStoreSparesCompilation) {
    const std::string text = kHeader + kParams + kCounter + counterProgram("__miss__a", 1) +
                             counterProgram("__miss__b", 10);
    MapStore store;
    for (unsigned round = 0; round < 2; ++round) {
        const Module module = source(text);
        Runner run({missOf(module, "__miss__a"), missOf(module, "__miss__b")}, &store);
        EXPECT_EQ(101u, run.call(0));
        EXPECT_EQ(111u, run.call(1));
        EXPECT_EQ(3u, store.inserts) << "two programs and the variables";
        EXPECT_EQ(round * 3, store.hits);
    }
    // The store also knows one program of the same module in another pipeline.
    const Module module = source(text);
    Runner run({missOf(module, "__miss__b")}, &store);
    EXPECT_EQ(110u, run.call(0));
    EXPECT_EQ(3u, store.inserts);
}

TEST(Piece, ValuesThatCannotBeReadAreReplaced) {
    const Module module = source(kHeader + kParams + kCounter + counterProgram("__miss__a", 1));
    MapStore store;
    Runner({missOf(module, "__miss__a")}, &store);
    for (auto& [key, value] : store.values)
        value = "rubbish";
    Runner run({missOf(module, "__miss__a")}, &store);
    EXPECT_EQ(101u, run.call(0));
    for (auto& [key, value] : store.values)
        EXPECT_NE("rubbish", value);
}

TEST(Piece, PrecompiledProgramsAreUsed) {
    const Module module = source(kHeader + kParams + kCounter + counterProgram("__miss__a", 1));
    const auto own = std::make_shared<MapStore>();
    MapStore store;
    PipelineRules rules;
    rules.launchParams = "params";
    ProgramRequest program = missOf(module, "__miss__a");
    program.store = own;
    precompile(program, rules);
    EXPECT_EQ(1u, own->inserts);
    Runner run({program}, &store);
    EXPECT_EQ(101u, run.call(0));
    EXPECT_EQ(1u, own->hits);
    EXPECT_EQ(1u, store.inserts) << "the variables are made with the pipeline";
    stackNeed(program, rules);
    EXPECT_EQ(1u, own->inserts) << "compiled once, whoever asks";
}

TEST(Piece, TheFirstFaultyProgramIsNamed) {
    const Module module = source(std::string(kHeader) +
                                ".visible .entry __miss__good() { ret; }\n"
                                ".visible .entry __miss__bad() { .reg .b32 %r<3>;\n"
                                "call _optix_set_payload, (9, %r1);\nret; }\n"
                                ".visible .entry __miss__worse() { .reg .b32 %r<3>;\n"
                                "call _optix_set_payload, (10, %r1);\nret; }\n");
    for (int repeat = 0; repeat < 5; ++repeat)
        try {
            Runner({missOf(module, "__miss__good"), missOf(module, "__miss__bad"),
                    missOf(module, "__miss__worse")});
            FAIL() << "no error";
        } catch (const Error& error) {
            EXPECT_EQ(sunstone::Code::kInvalidPayloadAccess, error.code());
            EXPECT_EQ(0, std::string(error.what()).rfind("line 6", 0)) << error.what();
        }
}

TEST(Piece, KeysDependOnEverything) {
    const Module module = source(std::string(kHeader) + ".visible .entry __miss__a() { ret; }\n");
    const Module other = source(std::string(kHeader) + ".visible .entry __miss__a() {  ret; }\n");
    PieceRequest request;
    request.modules = {module.get()};
    request.function = "__miss__a";
    const std::string key = keyOf(request);
    EXPECT_EQ(16u, key.size());
    EXPECT_EQ(key, keyOf(request));
    const auto differs = [&](auto change) {
        PieceRequest changed = request;
        change(changed);
        EXPECT_NE(key, keyOf(changed));
    };
    differs([&](PieceRequest& r) { r.modules = {other.get()}; });
    differs([&](PieceRequest& r) { r.modules.push_back(other.get()); });
    differs([](PieceRequest& r) { r.function = "__miss__b"; });
    differs([](PieceRequest& r) { r.kind = ProgramKind::kAnyHit; });
    differs([](PieceRequest& r) { r.flavor = &kernelFlavor(); });
    differs([](PieceRequest& r) { r.module = 1; });
    differs([](PieceRequest& r) { r.optLevel = OptLevel::k0; });
    differs([](PieceRequest& r) { r.debugLevel = DebugLevel::kFull; });
    differs([](PieceRequest& r) { r.variables = {{0, 0, 0}}; });
    differs([](PieceRequest& r) { r.rules.launchParams = "p"; });
    differs([](PieceRequest& r) { r.rules.optix7.numPayloadValues = 1; });
    differs([](PieceRequest& r) { r.rules.optix7.numAttributeValues = 3; });
    differs([](PieceRequest& r) { r.rules.exceptionFlags = 1; });
    differs([](PieceRequest& r) { r.rules.primitiveTypeFlags = 1; });
    differs([](PieceRequest& r) { r.rules.traversableGraphFlags = 1; });
    differs([](PieceRequest& r) { r.rules.motionBlur = true; });
    // Each part of a module's options changes the key: those of a bound value and of a payload
    // type.
    std::set<std::string> keys = {key};
    const auto add = [&](const ModuleRules& rules) {
        PieceRequest changed = request;
        changed.moduleRules = {std::make_shared<const ModuleRules>(rules)};
        EXPECT_TRUE(keys.insert(keyOf(changed)).second) << keys.size();
    };
    add({{}, {{0, {1, 2, 3, 4}}}});
    add({{}, {{4, {1, 2, 3, 4}}}});
    add({{}, {{0, {1, 2, 3, 5}}}});
    add({{}, {{0, {1, 2}}, {2, {3, 4}}}});
    add({{{{1, 2}}}, {}});
    add({{{{1, 3}}}, {}});
    add({{{{1}}, {{2}}}, {}});
}

} // namespace
} // namespace sunstone::compiler::testing
