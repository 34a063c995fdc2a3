// SPDX-License-Identifier: Apache-2.0
// User objects: their destructor runs once, after the last reference is released by the program, a
// graph, its copies and executable forms, and launches in progress.
#include <cuda.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <climits>
#include <thread>

namespace {

class UserObjects : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        ASSERT_EQ(cuDevicePrimaryCtxRetain(&context_, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSetCurrent(context_), CUDA_SUCCESS);
        ASSERT_EQ(cuStreamCreate(&stream_, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
        ASSERT_EQ(cuGraphCreate(&graph_, 0), CUDA_SUCCESS);
    }
    void TearDown() override {
        EXPECT_EQ(cuStreamDestroy(stream_), CUDA_SUCCESS);
        EXPECT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
        EXPECT_EQ(cuDevicePrimaryCtxRelease(0), CUDA_SUCCESS);
    }
    CUuserObject make(unsigned references = 1) {
        CUuserObject object = nullptr;
        const auto destroy = [](void* count) { ++*static_cast<std::atomic<int>*>(count); };
        EXPECT_EQ(cuUserObjectCreate(&object, &destroyed_, destroy, references,
                                     CU_USER_OBJECT_NO_DESTRUCTOR_SYNC),
                  CUDA_SUCCESS);
        return object;
    }
    // The destructor runs on a thread of the library.
    bool isDestroyed() const {
        for (int i = 0; i < 5000 && destroyed_ == 0; ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return destroyed_ == 1;
    }
    bool isKept() const {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        return destroyed_ == 0;
    }

    CUcontext context_ = nullptr;
    CUstream stream_ = nullptr;
    CUgraph graph_ = nullptr;
    std::atomic<int> destroyed_{0};
};

TEST_F(UserObjects, BelongToTheProgram) {
    const CUuserObject object = make(2);
    EXPECT_EQ(cuUserObjectRetain(object, 3), CUDA_SUCCESS);
    EXPECT_EQ(cuUserObjectRelease(object, 4), CUDA_SUCCESS);
    EXPECT_TRUE(isKept());
    EXPECT_EQ(cuUserObjectRelease(object, 2), CUDA_ERROR_INVALID_VALUE) << "there is one";
    EXPECT_EQ(cuUserObjectRelease(object, 1), CUDA_SUCCESS);
    EXPECT_TRUE(isDestroyed());
    EXPECT_EQ(cuUserObjectRelease(object, 1), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuGraphDestroy(graph_), CUDA_SUCCESS);
}

// A new object may get the memory of a destroyed one.
TEST_F(UserObjects, StaleHandles) {
    const CUuserObject stale = make();
    ASSERT_EQ(cuUserObjectRelease(stale, 1), CUDA_SUCCESS);
    ASSERT_TRUE(isDestroyed());
    EXPECT_EQ(cuGraphReleaseUserObject(graph_, nullptr, 1), CUDA_ERROR_INVALID_VALUE);
    for (int i = 0; i < 100; ++i) {
        const CUuserObject object = make();
        ASSERT_NE(object, stale);
        ASSERT_EQ(cuUserObjectRetain(stale, 1), CUDA_ERROR_INVALID_VALUE) << i;
        ASSERT_EQ(cuGraphRetainUserObject(graph_, object, 1, CU_GRAPH_USER_OBJECT_MOVE),
                  CUDA_SUCCESS);
        ASSERT_EQ(cuGraphReleaseUserObject(graph_, stale, 1), CUDA_ERROR_INVALID_VALUE) << i;
        ASSERT_EQ(cuGraphReleaseUserObject(graph_, object, 1), CUDA_SUCCESS);
    }
    for (int i = 0; i < 5000 && destroyed_ < 101; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(destroyed_, 101);
    EXPECT_EQ(cuGraphDestroy(graph_), CUDA_SUCCESS);
}

TEST_F(UserObjects, BelongToGraphsAndTheirCopies) {
    const CUuserObject object = make();
    CUgraph copy = nullptr;
    CUgraphExec exec = nullptr;
    ASSERT_EQ(cuGraphRetainUserObject(graph_, object, 1, CU_GRAPH_USER_OBJECT_MOVE), CUDA_SUCCESS);
    EXPECT_EQ(cuUserObjectRelease(object, 1), CUDA_ERROR_INVALID_VALUE) << "it is the graph's";
    ASSERT_EQ(cuGraphClone(&copy, graph_), CUDA_SUCCESS);
    ASSERT_EQ(cuGraphInstantiateWithFlags(&exec, copy, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphDestroy(graph_), CUDA_SUCCESS);
    EXPECT_TRUE(isKept());
    EXPECT_EQ(cuGraphDestroy(copy), CUDA_SUCCESS);
    EXPECT_TRUE(isKept());
    EXPECT_EQ(cuGraphExecDestroy(exec), CUDA_SUCCESS);
    EXPECT_TRUE(isDestroyed());
}

TEST_F(UserObjects, AreReleasedByGraphs) {
    const CUuserObject object = make();
    ASSERT_EQ(cuGraphRetainUserObject(graph_, object, 2, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuUserObjectRelease(object, 1), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphReleaseUserObject(graph_, object, 3), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuGraphReleaseUserObject(graph_, object, 1), CUDA_SUCCESS);
    EXPECT_TRUE(isKept());
    EXPECT_EQ(cuGraphReleaseUserObject(graph_, object, 1), CUDA_SUCCESS);
    EXPECT_TRUE(isDestroyed());
    EXPECT_EQ(cuGraphDestroy(graph_), CUDA_SUCCESS);
}

// References are counted, not stored one by one.
TEST_F(UserObjects, AGraphHasAsManyReferencesAsAnIntCounts) {
    const CUuserObject object = make();
    ASSERT_EQ(cuGraphRetainUserObject(graph_, object, INT_MAX, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuUserObjectRelease(object, 1), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphReleaseUserObject(graph_, object, INT_MAX - 1), CUDA_SUCCESS);
    EXPECT_TRUE(isKept());
    EXPECT_EQ(cuGraphReleaseUserObject(graph_, object, 2), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuGraphReleaseUserObject(graph_, object, 1), CUDA_SUCCESS);
    EXPECT_TRUE(isDestroyed());
    EXPECT_EQ(cuGraphDestroy(graph_), CUDA_SUCCESS);
}

TEST_F(UserObjects, OutliveLaunchesInProgress) {
    const CUuserObject object = make();
    std::atomic<bool> goesOn{false};
    CUDA_HOST_NODE_PARAMS host = {[](void* flag) {
                                      while (!*static_cast<std::atomic<bool>*>(flag))
                                          std::this_thread::yield();
                                  },
                                  &goesOn};
    CUgraphNode node = nullptr;
    CUgraphExec exec = nullptr;
    ASSERT_EQ(cuGraphAddHostNode(&node, graph_, nullptr, 0, &host), CUDA_SUCCESS);
    ASSERT_EQ(cuGraphRetainUserObject(graph_, object, 1, CU_GRAPH_USER_OBJECT_MOVE), CUDA_SUCCESS);
    ASSERT_EQ(cuGraphInstantiateWithFlags(&exec, graph_, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuGraphLaunch(exec, stream_), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphExecDestroy(exec), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphDestroy(graph_), CUDA_SUCCESS);
    EXPECT_TRUE(isKept());
    goesOn = true;
    EXPECT_TRUE(isDestroyed());
    EXPECT_EQ(cuStreamSynchronize(stream_), CUDA_SUCCESS);
}

TEST_F(UserObjects, BadArguments) {
    const CUuserObject object = make();
    const auto bad = CUDA_ERROR_INVALID_VALUE;
    const auto destroy = [](void*) {};
    constexpr unsigned kFlags = CU_USER_OBJECT_NO_DESTRUCTOR_SYNC;
    CUuserObject made = nullptr;
    EXPECT_EQ(cuUserObjectCreate(nullptr, nullptr, destroy, 1, kFlags), bad);
    EXPECT_EQ(cuUserObjectCreate(&made, nullptr, nullptr, 1, kFlags), bad);
    EXPECT_EQ(cuUserObjectCreate(&made, nullptr, destroy, 0, kFlags), bad);
    EXPECT_EQ(cuUserObjectCreate(&made, nullptr, destroy, ~0u, kFlags), bad);
    EXPECT_EQ(cuUserObjectCreate(&made, nullptr, destroy, 1, 0), bad);
    EXPECT_EQ(cuUserObjectRetain(nullptr, 1), bad);
    EXPECT_EQ(cuUserObjectRetain(object, 0), bad);
    EXPECT_EQ(cuUserObjectRelease(object, 0), bad);
    EXPECT_EQ(cuGraphRetainUserObject(nullptr, object, 1, 0), bad);
    EXPECT_EQ(cuGraphRetainUserObject(graph_, nullptr, 1, 0), bad);
    EXPECT_EQ(cuGraphRetainUserObject(graph_, object, 0, 0), bad);
    EXPECT_EQ(cuGraphRetainUserObject(graph_, object, 1, 2), bad);
    EXPECT_EQ(cuGraphRetainUserObject(graph_, object, 2, CU_GRAPH_USER_OBJECT_MOVE), bad);
    EXPECT_EQ(cuGraphReleaseUserObject(graph_, object, 1), bad);
    EXPECT_EQ(cuGraphDestroy(graph_), CUDA_SUCCESS);
    EXPECT_TRUE(isKept());
    EXPECT_EQ(cuUserObjectRelease(object, 1), CUDA_SUCCESS);
    EXPECT_TRUE(isDestroyed());
}

} // namespace
