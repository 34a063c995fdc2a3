// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API on a C API that records its calls: members that are several
// calls, reference counts, and exceptions.
#include "fixture.h"

using namespace optix;

namespace {

TEST_F(OptixPp, ContextsMakeBuffers) {
    const RTformat f = RT_FORMAT_FLOAT4;
    void* made = recorder.newObject();
    recorder.names[made] = "made";
    recorder.objects["rtBufferCreate"] = recorder.objects["rtBufferCreateForCUDA"] = made;
    const std::string create = "rtBufferCreate(context, 1, out)";
    const std::string format = "rtBufferSetFormat(made, 260)";
    const std::string levels = "rtBufferSetMipLevelCount(made, 6)";
    CALLS(context->createBuffer(1), create);
    CALLS(context->createBuffer(1, f), create, format);
    CALLS(context->createBuffer(1, f, 3), create, format, "rtBufferSetSize1D(made, 3)");
    CALLS(context->createBuffer(1, f, 3, 4), create, format, "rtBufferSetSize2D(made, 3, 4)");
    CALLS(context->createBuffer(1, f, 3, 4, 5), create, format, "rtBufferSetSize3D(made, 3, 4, 5)");
    CALLS(context->createMipmappedBuffer(1, f, 3, 6), create, format, "rtBufferSetSize1D(made, 3)",
          levels);
    CALLS(context->createMipmappedBuffer(1, f, 3, 4, 6), create, format,
          "rtBufferSetSize2D(made, 3, 4)", levels);
    CALLS(context->createMipmappedBuffer(1, f, 3, 4, 5, 6), create, format,
          "rtBufferSetSize3D(made, 3, 4, 5)", levels);
    CALLS(context->create1DLayeredBuffer(1, f, 3, 4, 6), "rtBufferCreate(context, 2097153, out)",
          format, "rtBufferSetSize3D(made, 3, 1, 4)", levels);
    CALLS(context->create2DLayeredBuffer(1, f, 3, 4, 5, 6), "rtBufferCreate(context, 2097153, out)",
          format, "rtBufferSetSize3D(made, 3, 4, 5)", levels);
    CALLS(context->createCubeBuffer(1, f, 3, 4, 6), "rtBufferCreate(context, 4194305, out)", format,
          "rtBufferSetSize3D(made, 3, 4, 6)", levels);
    CALLS(context->createCubeLayeredBuffer(1, f, 3, 4, 12, 6),
          "rtBufferCreate(context, 6291457, out)", format, "rtBufferSetSize3D(made, 3, 4, 12)",
          levels);
    const std::string forCuda = "rtBufferCreateForCUDA(context, 1, out)";
    CALLS(context->createBufferForCUDA(1), forCuda);
    CALLS(context->createBufferForCUDA(1, f), forCuda, format);
    CALLS(context->createBufferForCUDA(1, f, 3), forCuda, format, "rtBufferSetSize1D(made, 3)");
    CALLS(context->createBufferForCUDA(1, f, 3, 4), forCuda, format,
          "rtBufferSetSize2D(made, 3, 4)");
    CALLS(context->createBufferForCUDA(1, f, 3, 4, 5), forCuda, format,
          "rtBufferSetSize3D(made, 3, 4, 5)");
}

TEST_F(OptixPp, ContextsMakeOtherObjects) {
    void* made = recorder.newObject();
    recorder.names[made] = "made";
    for (const char* name : {"rtAccelerationCreate", "rtGeometryInstanceCreate", "rtGroupCreate",
                             "rtGeometryGroupCreate"})
        recorder.objects[name] = made;
    CALLS(context->createAcceleration("Trbvh"), "rtAccelerationCreate(context, out)",
          "rtAccelerationSetBuilder(made, Trbvh)");
    CALLS(context->createAcceleration("Bvh", "Bvh"), "rtAccelerationCreate(context, out)",
          "rtAccelerationSetBuilder(made, Bvh)");
    CALLS(context->createGeometryInstance(), "rtGeometryInstanceCreate(context, out)");
    CALLS(context->createGeometryInstance(geometry, &material, &material + 1),
          "rtGeometryInstanceCreate(context, out)", "rtGeometryInstanceSetGeometry(made, geometry)",
          "rtGeometryInstanceSetMaterialCount(made, 1)",
          "rtGeometryInstanceSetMaterial(made, 0, material)");
    CALLS(context->createGeometryInstance(triangles, material),
          "rtGeometryInstanceCreate(context, out)",
          "rtGeometryInstanceSetGeometryTriangles(made, triangles)",
          "rtGeometryInstanceSetMaterialCount(made, 1)",
          "rtGeometryInstanceSetMaterial(made, 0, material)");
    const std::vector<Transform> transforms(2, transform);
    CALLS(context->createGroup(transforms.begin(), transforms.end()), "rtGroupCreate(context, out)",
          "rtGroupSetChildCount(made, 2)", "rtGroupSetChild(made, 0, transform)",
          "rtGroupSetChild(made, 1, transform)");
    CALLS(context->createGeometryGroup(&instance, &instance + 1),
          "rtGeometryGroupCreate(context, out)", "rtGeometryGroupSetChildCount(made, 1)",
          "rtGeometryGroupSetChild(made, 0, instance)");
    const std::vector<std::string> strings = {"a", "b"};
    const std::vector<const char*> pointers = {"a", "b", "c"};
    CALLS(context->createProgramFromPTXFiles(strings, "main"),
          "rtProgramCreateFromPTXFiles(context, 2, input, main, out)");
    CALLS(context->createProgramFromPTXFiles(pointers, "main"),
          "rtProgramCreateFromPTXFiles(context, 3, input, main, out)");
    CALLS(context->createProgramFromPTXStrings(strings, "main"),
          "rtProgramCreateFromPTXStrings(context, 2, input, main, out)");
    CALLS(context->createProgramFromPTXStrings(pointers, "main"),
          "rtProgramCreateFromPTXStrings(context, 3, input, main, out)");
}

TEST_F(OptixPp, ContextsHaveAttributes) {
    const auto get = [](int attribute, int size) {
        return "rtContextGetAttribute(context, " + std::to_string(attribute) + ", " +
               std::to_string(size) + ", input)";
    };
    const auto set = [](int attribute, int size) {
        return "rtContextSetAttribute(context, " + std::to_string(attribute) + ", " +
               std::to_string(size) + ", input)";
    };
    CALLS(context->getMaxTextureCount(), get(RT_CONTEXT_ATTRIBUTE_MAX_TEXTURE_COUNT, 4));
    CALLS(context->getCPUNumThreads(), get(RT_CONTEXT_ATTRIBUTE_CPU_NUM_THREADS, 4));
    CALLS(context->getUsedHostMemory(), get(RT_CONTEXT_ATTRIBUTE_USED_HOST_MEMORY, 8));
    CALLS(context->getPreferFastRecompiles(), get(RT_CONTEXT_ATTRIBUTE_PREFER_FAST_RECOMPILES, 4));
    CALLS(context->getForceInlineUserFunctions(),
          get(RT_CONTEXT_ATTRIBUTE_FORCE_INLINE_USER_FUNCTIONS, 4));
    CALLS(context->getGPUPagingActive(), get(RT_CONTEXT_ATTRIBUTE_GPU_PAGING_ACTIVE, 4));
    CALLS(context->getGPUPagingForcedOff(), get(RT_CONTEXT_ATTRIBUTE_GPU_PAGING_FORCED_OFF, 4));
    CALLS(context->getAvailableDeviceMemory(2),
          get(RT_CONTEXT_ATTRIBUTE_AVAILABLE_DEVICE_MEMORY + 2, 8));
    CALLS(context->getDiskCacheLocation(), get(RT_CONTEXT_ATTRIBUTE_DISK_CACHE_LOCATION, 8));
    RTsize low = 0, high = 0;
    CALLS(context->getDiskCacheMemoryLimits(low, high),
          get(RT_CONTEXT_ATTRIBUTE_DISK_CACHE_MEMORY_LIMITS, 16));
    CALLS(context->setCPUNumThreads(3), set(RT_CONTEXT_ATTRIBUTE_CPU_NUM_THREADS, 4));
    CALLS(context->setPreferFastRecompiles(true),
          set(RT_CONTEXT_ATTRIBUTE_PREFER_FAST_RECOMPILES, 4));
    CALLS(context->setForceInlineUserFunctions(true),
          set(RT_CONTEXT_ATTRIBUTE_FORCE_INLINE_USER_FUNCTIONS, 4));
    CALLS(context->setDiskCacheLocation("/tmp"), set(RT_CONTEXT_ATTRIBUTE_DISK_CACHE_LOCATION, 8));
    CALLS(context->setDiskCacheMemoryLimits(1, 2),
          set(RT_CONTEXT_ATTRIBUTE_DISK_CACHE_MEMORY_LIMITS, 16));
    CALLS(context->setGPUPagingForcedOff(1), set(RT_CONTEXT_ATTRIBUTE_GPU_PAGING_FORCED_OFF, 4));
    CALLS(context->setAttribute(RT_CONTEXT_ATTRIBUTE_CPU_NUM_THREADS, 2.0),
          set(RT_CONTEXT_ATTRIBUTE_CPU_NUM_THREADS, 8));
}

TEST_F(OptixPp, ContextsAndDevices) {
    recorder.numbers["rtDeviceGetDeviceCount"] = 3;
    EXPECT_EQ(Context::getDeviceCount(), 3u);
    const auto get = [](int attribute, const char* size, const char* place) {
        return "rtDeviceGetAttribute(1, " + std::to_string(attribute) + ", " + size + ", " + place +
               ")";
    };
    CALLS(ContextObj::getDeviceName(1), get(RT_DEVICE_ATTRIBUTE_NAME, "512", "input"));
    CALLS(ContextObj::getDevicePCIBusId(1), get(RT_DEVICE_ATTRIBUTE_PCI_BUS_ID, "16", "input"));
    CALLS(ContextObj::getDeviceAttribute(1, RT_DEVICE_ATTRIBUTE_CLOCK_RATE, 4, memory),
          get(RT_DEVICE_ATTRIBUTE_CLOCK_RATE, "4", "memory"));
    CALLS(ContextObj::getCompatibleDevices(1), "rtDeviceGetDeviceCount(out)",
          get(RT_DEVICE_ATTRIBUTE_COMPATIBLE_DEVICES, "16", "input"));
    const int devices[2] = {0, 1};
    CALLS(context->setDevices(devices, devices + 2), "rtContextSetDevices(context, 2, input)");
    recorder.numbers["rtContextGetDeviceCount"] = 2;
    EXPECT_EQ(context->getEnabledDevices().size(), 2u);
    CALLS(context->getPrintLaunchIndex(), "rtContextGetPrintLaunchIndex(context, out, out, out)");
    CALLS(context->setPrintLaunchIndex(1), "rtContextSetPrintLaunchIndex(context, 1, -1, -1)");
    EXPECT_EQ(context->getErrorString(RT_ERROR_INVALID_VALUE), "context 1281");
    CALLS(Context::create(), "rtContextCreate(out)");
}

TEST_F(OptixPp, NodesHaveChildren) {
    CALLS(group->setChild(2, transform), "rtGroupSetChild(group, 2, transform)");
    CALLS(selector->setChild(2, group), "rtSelectorSetChild(selector, 2, group)");
    CALLS(transform->setChild(group), "rtTransformSetChild(transform, group)");
    CALLS(group->getChild<Transform>(2), "rtGroupGetChild(group, 2, out)");
    CALLS(selector->getChild<GeometryGroup>(2), "rtSelectorGetChild(selector, 2, out)");
    CALLS(transform->getChild<GeometryGroup>(), "rtTransformGetChild(transform, out)");
    CALLS(group->addChild(transform), "rtGroupGetChildCount(group, out)",
          "rtGroupSetChildCount(group, 42)", "rtGroupSetChild(group, 41, transform)");
    EXPECT_EQ(selector->addChild(transform), 41u);
    EXPECT_EQ(geometryGroup->addChild(instance), 41u);
    CALLS(instance->addMaterial(material), "rtGeometryInstanceGetMaterialCount(instance, out)",
          "rtGeometryInstanceSetMaterialCount(instance, 42)",
          "rtGeometryInstanceSetMaterial(instance, 41, material)");
}

TEST_F(OptixPp, GroupsFillTheHoleOfARemovedChild) {
    recorder.numbers["rtGroupGetChildCount"] = recorder.numbers["rtGeometryGroupGetChildCount"] = 4;
    recorder.objects["rtGroupGetChild"] = transform->get();
    recorder.objects["rtGeometryGroupGetChild"] = instance->get();
    EXPECT_EQ(group->getChildIndex(transform), 0u);
    CALLS(group->removeChild(1u), "rtGroupGetChildCount(group, out)",
          "rtGroupGetChildCount(group, out)", "rtGroupGetChild(group, 3, out)",
          "rtGroupSetChild(group, 1, transform)", "rtGroupSetChildCount(group, 3)");
    EXPECT_EQ(group->removeChild(transform), 0u);
    EXPECT_EQ(recorder.calls.back(), "rtGroupSetChildCount(group, 3)");
    group->removeChild(3);
    EXPECT_EQ(geometryGroup->removeChild(instance), 0u);
    EXPECT_EQ(recorder.calls.back(), "rtGeometryGroupSetChildCount(geometryGroup, 3)");
    geometryGroup->removeChild(1);
    geometryGroup->removeChild(1u);
    try {
        group->removeChild(4u);
        ADD_FAILURE();
    } catch (const Exception& e) {
        EXPECT_STREQ(e.what(), "Group::removeChild: child 4 of 4");
    }
    EXPECT_THROW(group->removeChild(-1), Exception);
    EXPECT_THROW(group->removeChild(group), Exception);
    EXPECT_THROW(geometryGroup->removeChild(4), Exception);
}

TEST_F(OptixPp, SelectorsCloseTheGapOfARemovedChild) {
    recorder.numbers["rtSelectorGetChildCount"] = 3;
    recorder.objects["rtSelectorGetChild"] = group->get();
    CALLS(selector->removeChild(0u), "rtSelectorGetChildCount(selector, out)",
          "rtSelectorGetChild(selector, 1, out)", "rtSelectorSetChild(selector, 0, group)",
          "rtSelectorGetChild(selector, 2, out)", "rtSelectorSetChild(selector, 1, group)",
          "rtSelectorSetChildCount(selector, 2)");
    selector->removeChild(2);
    EXPECT_EQ(selector->removeChild(group), 0u);
    EXPECT_EQ(selector->getChildIndex(group), 0u);
    EXPECT_THROW(selector->removeChild(transform), Exception);
    EXPECT_THROW(selector->removeChild(3), Exception);
}

TEST_F(OptixPp, GeometryHasDefaults) {
    const RTformat f = RT_FORMAT_FLOAT3;
    CALLS(triangles->setVertices(7, buffer, f),
          "rtGeometryTrianglesSetVertices(triangles, 7, buffer, 0, 12, 259)");
    CALLS(triangles->setVertices(7, buffer, 4, f),
          "rtGeometryTrianglesSetVertices(triangles, 7, buffer, 4, 12, 259)");
    CALLS(triangles->setTriangleIndices(buffer, f),
          "rtGeometryTrianglesSetTriangleIndices(triangles, buffer, 0, 12, 259)");
    CALLS(triangles->setTriangleIndices(buffer, 4, f),
          "rtGeometryTrianglesSetTriangleIndices(triangles, buffer, 4, 12, 259)");
    CALLS(triangles->setTriangleIndices(buffer, RT_FORMAT_UNSIGNED_SHORT3),
          "rtGeometryTrianglesSetTriangleIndices(triangles, buffer, 0, 6, 275)");
    CALLS(triangles->setVertices(7, buffer, RT_FORMAT_HALF2),
          "rtGeometryTrianglesSetVertices(triangles, 7, buffer, 0, 4, 289)");
    CALLS(triangles->setVertices(7, buffer, RT_FORMAT_USER),
          "rtGeometryTrianglesSetVertices(triangles, 7, buffer, 0, 0, 285)");
    CALLS(triangles->setMotionVerticesMultiBuffer(7, &buffer, &buffer + 1, 4, 16, f),
          "rtGeometryTrianglesSetMotionVerticesMultiBuffer(triangles, 7, buffer, 1, 4, 16, 259)");
    const Handle<GeometryObj> constant = geometry;
    CALLS(constant->setFlags(), "rtGeometryGetFlags(geometry, out)");
}

TEST_F(OptixPp, BuffersAndSamplersHaveDefaults) {
    CALLS(buffer->map(), "rtBufferMapEx(buffer, 2, 0, null, out)");
    CALLS(buffer->map(1, RT_BUFFER_MAP_READ, memory), "rtBufferMapEx(buffer, 1, 1, memory, out)");
    CALLS(buffer->unmap(), "rtBufferUnmapEx(buffer, 0)");
    CALLS(buffer->getDevicePointer(1), "rtBufferGetDevicePointer(buffer, 1, out)");
    EXPECT_TRUE(buffer->getProgressiveUpdateReady());
    EXPECT_EQ(recorder.calls.back(), "rtBufferGetProgressiveUpdateReady(buffer, out, null, null)");
    unsigned count = 0, most = 0;
    CALLS(buffer->getProgressiveUpdateReady(count),
          "rtBufferGetProgressiveUpdateReady(buffer, out, out, null)");
    CALLS(buffer->getProgressiveUpdateReady(count, most),
          "rtBufferGetProgressiveUpdateReady(buffer, out, out, out)");
    EXPECT_EQ(count, 41u);
    CALLS(sampler->setBuffer(buffer), "rtTextureSamplerSetBuffer(sampler, 0, 0, buffer)");
    CALLS(sampler->getBuffer(), "rtTextureSamplerGetBuffer(sampler, 0, 0, out)");
}

TEST_F(OptixPp, EachObjectIsDestroyedValidatedAndAsked) {
#define LIFE(object, Name)                                                                         \
    CALLS(object->validate(), "rt" #Name "Validate(" #object ")");                                 \
    CALLS(object->getContext(), "rt" #Name "GetContext(" #object ", out)");                        \
    CALLS(object->destroy(), "rt" #Name "Destroy(" #object ")");                                   \
    EXPECT_EQ(object->get(), nullptr);
    LIFE(acceleration, Acceleration)
    LIFE(buffer, Buffer)
    LIFE(geometryGroup, GeometryGroup)
    LIFE(instance, GeometryInstance)
    LIFE(geometry, Geometry)
    LIFE(triangles, GeometryTriangles)
    LIFE(group, Group)
    LIFE(material, Material)
    LIFE(program, Program)
    LIFE(selector, Selector)
    LIFE(sampler, TextureSampler)
    LIFE(transform, Transform)
#undef LIFE
    CALLS(list->validate(), "rtCommandListGetContext(list, out)");
    CALLS(list->destroy(), "rtCommandListDestroy(list)");
    CALLS(stage->validate(), "rtPostProcessingStageGetContext(stage, out)");
    CALLS(stage->destroy(), "rtPostProcessingStageDestroy(stage)");
    CALLS(variable->getContext(), "rtVariableGetContext(variable, out)");
    CALLS(context->validate(), "rtContextValidate(context)");
    EXPECT_EQ(context->getContext()->get(), context->get());
    recorder.results["rtContextDestroy"] = RT_ERROR_LAUNCH_FAILED;
    EXPECT_THROW(context->destroy(), Exception);
    EXPECT_EQ(context->get(), nullptr);
}

// ---- Handles
// --------------------------------------------------------------------------------------

// A wrapper that tells when it is deleted.
class Counted : public APIObj {
public:
    explicit Counted(bool& alive) : alive_(alive) { alive_ = true; }
    ~Counted() override { alive_ = false; }
    Context getContext() const override { return Context(); }

private:
    bool& alive_;
};

TEST_F(OptixPp, HandlesCountReferences) {
    bool alive = false, other = false;
    Handle<Counted> first(new Counted(alive));
    {
        const Handle<Counted> second = first;
        Handle<APIObj> base = second;
        first = Handle<Counted>();
        EXPECT_FALSE(first);
        EXPECT_TRUE(alive);
        base = Handle<Counted>(new Counted(other));
        EXPECT_TRUE(other);
    }
    EXPECT_FALSE(alive);
    EXPECT_FALSE(other);
    first = new Counted(alive);
    Handle<Counted>& same = first;
    first = same;
    EXPECT_TRUE(alive);
    first->addReference();
    EXPECT_EQ(first->removeReference(), 1);
    first = nullptr;
    EXPECT_FALSE(alive);
}

TEST_F(OptixPp, HandlesOfNothingRefuse) {
    Buffer none;
    EXPECT_FALSE(none);
    EXPECT_EQ(none.get(), nullptr);
    EXPECT_FALSE(Buffer::take(RTbuffer(nullptr)));
    try {
        none->unmap();
        FAIL();
    } catch (const Exception& e) {
        EXPECT_EQ(e.getErrorCode(), RT_ERROR_INVALID_VALUE);
        EXPECT_STREQ(e.what(),
                     "use of a null handle: the object does not exist or a query found none");
    }
    CALLS(variable->set(none), "rtVariableSetObject(variable, null)");
    EXPECT_THROW(context["x"]->setProgramId(Program()), Exception);
}

TEST_F(OptixPp, TakingAnObjectTwiceMakesTwoWrappers) {
    const Buffer again = Buffer::take(buffer->get());
    EXPECT_NE(again.get(), buffer.get());
    EXPECT_EQ(Buffer(again)->get(), buffer->get());
}

TEST_F(OptixPp, IndexingFindsOrDeclaresVariables) {
    CALLS(context["x"], "rtContextQueryVariable(context, x, out)");
    recorder.objects["rtContextQueryVariable"] = nullptr;
    CALLS(context["x"], "rtContextQueryVariable(context, x, out)",
          "rtContextDeclareVariable(context, x, out)");
    CALLS(context[std::string("x")], "rtContextQueryVariable(context, x, out)",
          "rtContextDeclareVariable(context, x, out)");
    EXPECT_FALSE(context->queryVariable("x"));
    CALLS(selector["x"], "rtSelectorQueryVariable(selector, x, out)");
    CALLS(triangles["x"], "rtGeometryTrianglesQueryVariable(triangles, x, out)");
    CALLS(stage["x"], "rtPostProcessingStageQueryVariable(stage, x, out)");
    CALLS(program["x"], "rtProgramQueryVariable(program, x, out)");
    CALLS(Handle<ScopedObj>(material)["x"], "rtMaterialQueryVariable(material, x, out)");
}

// ---- Exceptions
// -----------------------------------------------------------------------------------

TEST_F(OptixPp, FailuresAreExceptionsWithTextAndCode) {
    recorder.results["rtBufferSetSize1D"] = RT_ERROR_ALREADY_MAPPED;
    try {
        buffer->setSize(3);
        FAIL();
    } catch (const Exception& e) {
        EXPECT_EQ(e.getErrorCode(), RT_ERROR_ALREADY_MAPPED);
        EXPECT_EQ(e.getErrorString(), "context 1541");
        EXPECT_STREQ(e.what(), "context 1541");
    }
    recorder.results["rtBufferGetContext"] = RT_ERROR_INVALID_VALUE; // a dead buffer
    try {
        buffer->setSize(3);
        FAIL();
    } catch (const std::exception& e) {
        EXPECT_STREQ(e.what(), "no context 1541");
    }
    EXPECT_THROW(buffer->getContext(), Exception);
    recorder.results["rtContextLaunch1D"] = RT_TIMEOUT_CALLBACK;
    context->launch(0, 1);
    recorder.results["rtContextLaunch1D"] = RT_ERROR_LAUNCH_FAILED;
    EXPECT_THROW(context->launch(0, 1), Exception);
}

TEST_F(OptixPp, CodesCanBeChecked) {
    buffer->checkError(RT_SUCCESS);
    buffer->checkErrorNoGetContext(RT_SUCCESS);
    EXPECT_THROW(buffer->checkError(RT_ERROR_UNKNOWN), Exception);
    EXPECT_THROW(buffer->checkError(RT_ERROR_UNKNOWN, context), Exception);
    EXPECT_THROW(buffer->checkErrorNoGetContext(RT_ERROR_UNKNOWN), Exception);
    EXPECT_EQ(APIObj::makeException(RT_ERROR_NO_DEVICE, nullptr).getErrorString(),
              "no context 1537");
    EXPECT_EQ(Exception::makeException(RT_ERROR_NO_DEVICE, context->get()).getErrorString(),
              "context 1537");
    EXPECT_EQ(Exception("text").getErrorCode(), RT_ERROR_UNKNOWN);
}

TEST_F(OptixPp, IdsAreFourBytes) {
    const rtBufferId<float, 2> bufferId(5);
    const rtCallableProgramId<float(int, float)> programId(6);
    EXPECT_EQ(bufferId.getId(), 5);
    EXPECT_EQ(programId.getId(), 6);
    EXPECT_EQ(sizeof(bufferId), 4u);
    EXPECT_EQ(sizeof(programId), 4u);
    rtMarkedCallableProgramId<float(int)> marked(7);
    (void)marked;
}

} // namespace
