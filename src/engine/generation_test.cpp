// SPDX-License-Identifier: Apache-2.0
// A minimal second generation of the ray tracing API on the engine: a flavor with one intrinsic,
// programs whose kind is part of the request and that take parameters, several entry points in one
// pipeline, and a bounds program. On the CPU and through the back end for GPUs.
#include "compiler/translate/unit.h"
#include "devlib/gpu/launch_block.h"
#include "engine/launch.h"
#include "engine/prepared_code.h"

#include "cuda.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <llvm/IR/InstIterator.h>

namespace sunstone::engine {
namespace {

using compiler::ProgramKind;
using devlib::RayState;

// Programs call _tiny_index() for the launch index. Names mean nothing; bounds programs take the
// primitive and the address of its box.
class TinyFlavor final : public compiler::Flavor {
public:
    const char* name() const override { return "tiny"; }
    bool isIntrinsicName(std::string_view name) const override { return name.starts_with("_tiny_"); }
    const compiler::Intrinsic* find(std::string_view name) const override {
        static const compiler::Intrinsic index = {"index", 0, 0, "r", "", ~0u, true};
        return name == "_tiny_index" ? &index : nullptr;
    }
    std::string launchIndex(char) const override { return "_tiny_index"; }
    std::string launchDimension(char) const override { return "_tiny_index"; }
    bool isProgramName(std::string_view) const override { return false; }
    std::optional<size_t> parameterAt(ProgramKind kind, size_t index, size_t) const override {
        if (kind != ProgramKind::kBounds || index > 1)
            return {};
        return index == 0 ? offsetof(RayState, hit) + offsetof(devlib::Hit, primitive)
                          : offsetof(RayState, payloadMemory);
    }
    void lower(compiler::Unit& unit, const compiler::ProgramPayloads&) const override {
        for (llvm::Function& function : unit.module())
            for (llvm::Instruction& each :
                 llvm::make_early_inc_range(llvm::instructions(function)))
                if (auto* call = llvm::dyn_cast<llvm::CallInst>(&each);
                    call && call->getCalledFunction() &&
                    unit.intrinsicOf(call->getCalledFunction()))
                    lowerIndex(*call);
    }

private:
    static void lowerIndex(llvm::CallInst& call) {
        llvm::IRBuilder<> builder(&call);
        const auto at = [&](llvm::Value* base, size_t offset, llvm::Type* type) {
            llvm::Value* address = builder.CreateInBoundsGEP(builder.getInt8Ty(), base,
                                                             builder.getInt64(offset));
            return builder.CreateLoad(type, address);
        };
        llvm::Value* thread =
            at(call.getArgOperand(0), offsetof(RayState, thread), builder.getPtrTy());
        call.replaceAllUsesWith(at(thread, offsetof(devlib::ThreadState, index), call.getType()));
        call.eraseFromParent();
    }
};

const TinyFlavor kTiny;

// Two entry points, which write 10 * index and 100 * index, and a bounds program.
const char* const kPrograms = R"(.version 7.0
.target sm_60
.address_size 64
.const .align 8 .b8 params[8];
.func (.param .b32 result) _tiny_index();
.visible .entry tens() {
  .reg .b32 %r<4>; .reg .b64 %rd<5>;
  call (%r1), _tiny_index, ();
  mul.lo.u32 %r2, %r1, 10;
  ld.const.u64 %rd1, [params]; mul.wide.u32 %rd2, %r1, 4; add.u64 %rd3, %rd1, %rd2;
  st.global.u32 [%rd3], %r2; ret; }
.visible .entry hundreds() {
  .reg .b32 %r<4>; .reg .b64 %rd<5>;
  mov.u32 %r1, %tid.x;
  mul.lo.u32 %r2, %r1, 100;
  ld.const.u64 %rd1, [params]; mul.wide.u32 %rd2, %r1, 4; add.u64 %rd3, %rd1, %rd2;
  st.global.u32 [%rd3], %r2; ret; }
.visible .entry box(.param .u32 primitive, .param .u64 result) {
  .reg .b32 %r<2>; .reg .b64 %rd<2>; .reg .f32 %f<4>;
  ld.param.u32 %r1, [primitive]; ld.param.u64 %rd1, [result];
  cvt.rn.f32.u32 %f1, %r1; neg.f32 %f2, %f1; add.f32 %f3, %f1, 0f3F000000;
  st.global.f32 [%rd1], %f1; st.global.f32 [%rd1+4], %f2; st.global.f32 [%rd1+8], %f1;
  st.global.f32 [%rd1+12], %f3; st.global.f32 [%rd1+16], %f3; st.global.f32 [%rd1+20], %f3;
  ret; }
)";

// Before the settings are read.
[[maybe_unused]] const int kBackEnd = setenv("SUNSTONE_GPU_BACK_END", "cpu-device", 1);

enum class Target { kCpu, kGpu };

class Generation : public ::testing::TestWithParam<Target> {
protected:
    void SetUp() override {
        context_->wording = &plainWording();
        context_->log = [this](LogLevel, std::string_view, std::string_view text) {
            log_ += std::string(text) + "\n";
        };
        if (GetParam() == Target::kCpu) {
            context_->backend = cpuBackend();
        } else {
            ASSERT_EQ(CUDA_SUCCESS, driver<decltype(cuInit)>("cuInit")(0));
            ASSERT_EQ(CUDA_SUCCESS, driver<decltype(cuDevicePrimaryCtxRetain)>(
                                        "cuDevicePrimaryCtxRetain")(&cuda_, 0));
            ASSERT_EQ(CUDA_SUCCESS, driver<decltype(cuCtxSetCurrent)>("cuCtxSetCurrent")(cuda_));
            context_->backend = createGpuBackend(cuda_);
        }
        context_->device = &context_->backend->device();
        module_->source = std::make_shared<const compiler::Source>(kPrograms);
        module_->moduleRules = std::make_shared<const compiler::ModuleRules>();
        module_->summary.selfContained = true;
        module_->summary.launchParamsSize = 8;
        module_->prepared = std::make_shared<PreparedCode>(nullptr);
        module_->rules.launchParams = "params";
        for (uint32_t i = 0; i < 3; ++i)
            addGroup(i, i < 2 ? devlib::kGroupRaygen : devlib::kGroupBounds,
                     i < 2 ? ProgramKind::kRaygen : ProgramKind::kBounds);
        pipeline_ = createPipeline(*context_, groups_, module_->rules, {}, &kTiny);
    }
    void TearDown() override {
        pipeline_.reset();
        context_.reset();
    }

    // Functions of the CPU device's driver, which replaces a GPU's.
    template <class Function>
    static Function* driver(const char* name) {
        static void* const library = dlopen(TEST_CUDA_LIBRARY, RTLD_NOW | RTLD_LOCAL);
        return reinterpret_cast<Function*>(dlsym(library, name));
    }
    static CUresult synchronizeGpu() {
        return driver<decltype(cuCtxSynchronize)>("cuCtxSynchronize")();
    }

    void addGroup(uint32_t i, devlib::GroupKind kind, ProgramKind program) {
        const char* const names[] = {"tens", "hundreds", "box"};
        auto group = std::make_shared<ProgramGroup>();
        group->number = 1000 + i; // not the context's first
        group->kind = kind;
        group->programs[devlib::kRoleMain] = {module_, names[i], program, -1};
        packSbtHeader(*group, &records_[i]);
        groups_.push_back(std::move(group));
    }

    void synchronize() {
        if (cuda_)
            ASSERT_EQ(CUDA_SUCCESS, synchronizeGpu());
        else
            context_->device->synchronize(nullptr);
        context_->backend->flush(*context_);
    }

    ContextPtr context_ = std::make_shared<Context>();
    CUcontext cuda_ = nullptr;
    std::shared_ptr<Module> module_ = std::make_shared<Module>();
    std::vector<std::shared_ptr<ProgramGroup>> groups_;
    std::shared_ptr<Pipeline> pipeline_;
    alignas(16) devlib::SbtHeader records_[3] = {};
    std::string log_;
};

TEST_P(Generation, EntriesAreChosenByTheirRecord) {
    for (uint32_t entry = 0; entry < 2; ++entry) {
        uint32_t out[70] = {};
        uint32_t* const params = out;
        LaunchRequest request;
        request.pipeline = pipeline_;
        request.sbt.entryRecord = uint64_t(&records_[entry]);
        request.params = &params;
        request.paramsSize = sizeof params;
        request.width = 70;
        request.height = request.depth = 1;
        launch(context_, request);
        synchronize();
        for (uint32_t i = 0; i < 70; ++i)
            ASSERT_EQ(out[i], i * (entry == 0 ? 10 : 100)) << log_;
    }
}

TEST_P(Generation, BoundsProgramsWriteBoxes) {
    float boxes[33][6] = {};
    BoundsRequest request;
    request.pipeline = pipeline_;
    request.sbt.entryRecord = uint64_t(&records_[2]);
    request.count = 33;
    request.boxes = boxes[0];
    launchBounds(context_, request);
    synchronize();
    for (int i = 0; i < 33; ++i) {
        const float x = float(i), expected[6] = {x, -x, x, x + 0.5f, x + 0.5f, x + 0.5f};
        ASSERT_EQ(0, std::memcmp(boxes[i], expected, sizeof expected)) << i << " " << log_;
    }
}

TEST_P(Generation, AProgramOfAnotherKindIsRefused) {
    BoundsRequest request;
    request.pipeline = pipeline_;
    request.sbt.entryRecord = uint64_t(&records_[0]); // an entry point, not a bounds program
    request.count = 1;
    float box[6] = {};
    request.boxes = box;
    launchBounds(context_, request);
    if (cuda_)
        synchronizeGpu();
    else
        EXPECT_THROW(context_->device->synchronize(nullptr), Error);
    context_->backend->flush(*context_);
    EXPECT_NE(log_, "");
    EXPECT_EQ(box[0], 0);
}

TEST_P(Generation, ProgramsOfOtherKindsTakeNoParameters) {
    groups_[2]->kind = devlib::kGroupRaygen;
    groups_[2]->programs[devlib::kRoleMain].kind = ProgramKind::kRaygen;
    try {
        createPipeline(*context_, groups_, module_->rules, {}, &kTiny);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), Code::kInvalidPtx);
        EXPECT_NE(std::string(error.what()).find("\"box\""), std::string::npos) << error.what();
    }
}

INSTANTIATE_TEST_SUITE_P(Targets, Generation, ::testing::Values(Target::kCpu, Target::kGpu),
                         [](const auto& info) {
                             return info.param == Target::kCpu ? "cpu" : "gpu";
                         });

} // namespace
} // namespace sunstone::engine
