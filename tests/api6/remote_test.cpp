// SPDX-License-Identifier: Apache-2.0
// Remote devices with a single rank, this machine: calls, errors, handles. ranks/ has the tests
// with several ranks.
#include "support.h"

#include <thread>

namespace sunstone::api6 {
namespace {

class Remote : public Classic {
protected:
    void SetUp() override {
        Classic::SetUp();
        ASSERT_EQ(rtRemoteDeviceCreate("mpi:", "name", "password", &device_), RT_SUCCESS);
    }
    void TearDown() override {
        rtRemoteDeviceDestroy(device_);
        Classic::TearDown();
    }
    template <class T>
    T attribute(RTremotedeviceattribute which) {
        T value{};
        EXPECT_EQ(rtRemoteDeviceGetAttribute(device_, which, sizeof value, &value), RT_SUCCESS);
        return value;
    }

    RTremotedevice device_ = nullptr;
};

TEST_F(Remote, CreationNeedsAUrlOfRanks) {
    RTremotedevice made = device_;
    EXPECT_EQ(rtRemoteDeviceCreate(nullptr, "", "", &made), RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(made, nullptr);
    EXPECT_EQ(rtRemoteDeviceCreate("mpi:", "", "", nullptr), RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtRemoteDeviceCreate("wss://render.example:443", "", "", &made),
              RT_ERROR_CONNECTION_FAILED);
    EXPECT_EQ(made, nullptr);
    EXPECT_EQ(rtRemoteDeviceCreate("mpi://ranks", nullptr, nullptr, &made), RT_SUCCESS);
    EXPECT_NE(made, device_);
    EXPECT_EQ(rtRemoteDeviceDestroy(made), RT_SUCCESS);
}

TEST_F(Remote, NodesAreReservedAndReleased) {
    EXPECT_EQ(attribute<unsigned>(RT_REMOTEDEVICE_ATTRIBUTE_NUM_TOTAL_NODES), 1u);
    EXPECT_EQ(attribute<unsigned>(RT_REMOTEDEVICE_ATTRIBUTE_NUM_FREE_NODES), 1u);
    EXPECT_EQ(attribute<unsigned>(RT_REMOTEDEVICE_ATTRIBUTE_NUM_RESERVED_NODES), 0u);
    EXPECT_EQ(attribute<int>(RT_REMOTEDEVICE_ATTRIBUTE_STATUS), RT_REMOTEDEVICE_STATUS_CONNECTED);
    EXPECT_EQ(rtRemoteDeviceRelease(device_), RT_ERROR_CLUSTER_NOT_RUNNING);
    EXPECT_EQ(rtRemoteDeviceReserve(device_, 0, 0), RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtRemoteDeviceReserve(device_, 1, 1), RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtRemoteDeviceReserve(device_, 2, 0), RT_ERROR_INSUFFICIENT_FREE_NODES);
    EXPECT_EQ(rtRemoteDeviceReserve(device_, 1, 0), RT_SUCCESS);
    EXPECT_EQ(rtRemoteDeviceReserve(device_, 1, 0), RT_ERROR_CLUSTER_ALREADY_RUNNING);
    EXPECT_EQ(attribute<unsigned>(RT_REMOTEDEVICE_ATTRIBUTE_NUM_FREE_NODES), 0u);
    EXPECT_EQ(attribute<unsigned>(RT_REMOTEDEVICE_ATTRIBUTE_NUM_RESERVED_NODES), 1u);
    EXPECT_EQ(attribute<int>(RT_REMOTEDEVICE_ATTRIBUTE_STATUS), RT_REMOTEDEVICE_STATUS_RESERVED);
    RTremotedevice other = nullptr;
    EXPECT_EQ(rtRemoteDeviceCreate("mpi:", "", "", &other), RT_SUCCESS);
    EXPECT_EQ(rtRemoteDeviceReserve(other, 1, 0), RT_ERROR_INSUFFICIENT_FREE_NODES);
    EXPECT_EQ(rtRemoteDeviceRelease(device_), RT_SUCCESS);
    EXPECT_EQ(rtRemoteDeviceReserve(other, 1, 0), RT_SUCCESS);
    EXPECT_EQ(rtRemoteDeviceDestroy(other), RT_SUCCESS);
    EXPECT_EQ(attribute<unsigned>(RT_REMOTEDEVICE_ATTRIBUTE_NUM_FREE_NODES), 1u)
        << "a device that is destroyed has reserved nothing";
}

TEST_F(Remote, Attributes) {
    char text[32] = {};
    for (const auto which :
         {RT_REMOTEDEVICE_ATTRIBUTE_CLUSTER_URL, RT_REMOTEDEVICE_ATTRIBUTE_HEAD_NODE_URL}) {
        EXPECT_EQ(rtRemoteDeviceGetAttribute(device_, which, sizeof text, text), RT_SUCCESS);
        EXPECT_STREQ(text, "mpi:");
        EXPECT_EQ(rtRemoteDeviceGetAttribute(device_, which, 4, text), RT_ERROR_INVALID_VALUE);
    }
    EXPECT_EQ(
        rtRemoteDeviceGetAttribute(device_, RT_REMOTEDEVICE_ATTRIBUTE_NAME, sizeof text, text),
        RT_SUCCESS);
    EXPECT_STREQ(text, "Sunstone");
    EXPECT_EQ(attribute<unsigned>(RT_REMOTEDEVICE_ATTRIBUTE_NUM_CONFIGURATIONS), 1u);
    EXPECT_EQ(rtRemoteDeviceGetAttribute(device_, RT_REMOTEDEVICE_ATTRIBUTE_CONFIGURATIONS,
                                         sizeof text, text),
              RT_SUCCESS);
    EXPECT_NE(text[0], 0);
    const auto second =
        RTremotedeviceattribute(unsigned(RT_REMOTEDEVICE_ATTRIBUTE_CONFIGURATIONS) + 1);
    EXPECT_EQ(rtRemoteDeviceGetAttribute(device_, second, sizeof text, text),
              RT_ERROR_INVALID_VALUE);
    EXPECT_GT(attribute<RTsize>(RT_REMOTEDEVICE_ATTRIBUTE_GPU_TOTAL_MEMORY), RTsize(1) << 20);
    EXPECT_EQ(rtRemoteDeviceGetAttribute(device_, RT_REMOTEDEVICE_ATTRIBUTE_STATUS, 8, text),
              RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtRemoteDeviceGetAttribute(device_, RT_REMOTEDEVICE_ATTRIBUTE_STATUS, 4, nullptr),
              RT_ERROR_INVALID_VALUE);
}

TEST_F(Remote, ContextsUseADeviceWithNodes) {
    fails(RT_ERROR_CLUSTER_NOT_RUNNING, rtContextSetRemoteDevice(context_, device_), "no reserved");
    EXPECT_EQ(rtRemoteDeviceReserve(device_, 1, 0), RT_SUCCESS);
    ok(rtContextSetRemoteDevice(context_, device_));
    RTbuffer source = nullptr, stream = nullptr;
    ok(rtBufferCreate(context_, RT_BUFFER_OUTPUT, &source));
    ok(rtBufferSetFormat(source, RT_FORMAT_FLOAT4));
    ok(rtBufferSetSize2D(source, 2, 2));
    ok(rtBufferCreate(context_, RT_BUFFER_PROGRESSIVE_STREAM, &stream));
    ok(rtBufferSetFormat(stream, RT_FORMAT_UNSIGNED_BYTE4));
    ok(rtBufferSetSize2D(stream, 2, 2));
    ok(rtBufferBindProgressiveStream(stream, source));
    ok(rtVariableSetObject(variable("picture"), source));
    ok(rtVariableSet1f(variable("scoped"), 0.2f));
    setEntry("write_subframe");
    ok(rtContextLaunchProgressive2D(context_, 0, 2, 2, 3));
    unsigned count = 0;
    int ready = 0;
    for (int i = 0; i < 20000 && count < 3; ++i) {
        ok(rtBufferGetProgressiveUpdateReady(stream, &ready, &count, nullptr));
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(count, 3u);
    EXPECT_EQ(rtRemoteDeviceRelease(device_), RT_SUCCESS);
    for (int i = 0; i < 2; ++i)
        fails(RT_ERROR_CLUSTER_NOT_RUNNING, rtContextLaunchProgressive2D(context_, 0, 2, 2, 4),
              "no reserved");
    EXPECT_EQ(rtRemoteDeviceDestroy(device_), RT_SUCCESS);
    fails(RT_ERROR_CLUSTER_NOT_RUNNING, rtContextLaunchProgressive2D(context_, 0, 2, 2, 4),
          "destroyed");
    ok(rtContextSetRemoteDevice(context_, nullptr));
    ok(rtContextLaunchProgressive2D(context_, 0, 2, 2, 4));
}

TEST_F(Remote, HandlesThatAreNone) {
    int local = 0;
    RTremotedevice destroyed = nullptr;
    EXPECT_EQ(rtRemoteDeviceCreate("mpi:", "", "", &destroyed), RT_SUCCESS);
    EXPECT_EQ(rtRemoteDeviceDestroy(destroyed), RT_SUCCESS);
    for (void* garbage : {static_cast<void*>(nullptr), static_cast<void*>(&local),
                          static_cast<void*>(context_), static_cast<void*>(destroyed)}) {
        const auto device = static_cast<RTremotedevice>(garbage);
        EXPECT_EQ(rtRemoteDeviceDestroy(device), RT_ERROR_INVALID_VALUE);
        EXPECT_EQ(rtRemoteDeviceReserve(device, 1, 0), RT_ERROR_INVALID_VALUE);
        EXPECT_EQ(rtRemoteDeviceRelease(device), RT_ERROR_INVALID_VALUE);
        EXPECT_EQ(rtRemoteDeviceGetAttribute(device, RT_REMOTEDEVICE_ATTRIBUTE_STATUS, 4, &local),
                  RT_ERROR_INVALID_VALUE);
        if (garbage) {
            EXPECT_EQ(rtContextSetRemoteDevice(context_, device), RT_ERROR_INVALID_VALUE);
        }
        if (garbage != context_) {
            EXPECT_EQ(rtContextSetRemoteDevice(static_cast<RTcontext>(garbage), device_),
                      RT_ERROR_INVALID_CONTEXT);
        }
    }
    EXPECT_EQ(rtContextSetRemoteDevice(reinterpret_cast<RTcontext>(device_), nullptr),
              RT_ERROR_INVALID_CONTEXT);
    RTcontext owner = nullptr;
    EXPECT_NE(rtBufferGetContext(reinterpret_cast<RTbuffer>(device_), &owner), RT_SUCCESS);
}

} // namespace
} // namespace sunstone::api6
