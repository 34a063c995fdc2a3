// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API on a C API that records its calls: members that are one call.
// Arguments have different values, so that swapped ones are found.
#include "fixture.h"

TEST_F(OptixPpMembers, Context) {
    CALLS(context->compile(), "rtContextCompile(context)");
    CALLS(context->getRunningState(), "rtContextGetRunningState(context, out)");
    CALLS(context->createBuffer(2u), "rtBufferCreate(context, 2, out)");
    CALLS(context->createBufferForCUDA(2u), "rtBufferCreateForCUDA(context, 2, out)");
    CALLS(context->createBufferFromGLBO(2u, 3u), "rtBufferCreateFromGLBO(context, 2, 3, out)");
    CALLS(context->createTextureSamplerFromGLImage(2u, static_cast<RTgltarget>(3)),
          "rtTextureSamplerCreateFromGLImage(context, 2, 3, out)");
    CALLS(context->getBufferFromId(2), "rtContextGetBufferFromId(context, 2, out)");
    CALLS(context->getProgramFromId(2), "rtContextGetProgramFromId(context, 2, out)");
    CALLS(context->getTextureSamplerFromId(2), "rtContextGetTextureSamplerFromId(context, 2, out)");
    CALLS(context->createGeometry(), "rtGeometryCreate(context, out)");
    CALLS(context->createGeometryTriangles(), "rtGeometryTrianglesCreate(context, out)");
    CALLS(context->createGeometryInstance(), "rtGeometryInstanceCreate(context, out)");
    CALLS(context->createGroup(), "rtGroupCreate(context, out)");
    CALLS(context->createGeometryGroup(), "rtGeometryGroupCreate(context, out)");
    CALLS(context->createTransform(), "rtTransformCreate(context, out)");
    CALLS(context->createMaterial(), "rtMaterialCreate(context, out)");
    CALLS(context->createProgramFromPTXFile("s2", "s3"),
          "rtProgramCreateFromPTXFile(context, s2, s3, out)");
    CALLS(context->createProgramFromPTXString("s2", "s3"),
          "rtProgramCreateFromPTXString(context, s2, s3, out)");
    CALLS(context->createSelector(), "rtSelectorCreate(context, out)");
    CALLS(context->createTextureSampler(), "rtTextureSamplerCreate(context, out)");
    CALLS(context->createBuiltinPostProcessingStage("s2"),
          "rtPostProcessingStageCreateBuiltin(context, s2, out)");
    CALLS(context->createCommandList(), "rtCommandListCreate(context, out)");
    CALLS(context->getEnabledDeviceCount(), "rtContextGetDeviceCount(context, out)");
    CALLS(context->setStackSize(2u), "rtContextSetStackSize(context, 2)");
    CALLS(context->getStackSize(), "rtContextGetStackSize(context, out)");
    CALLS(context->setMaxCallableProgramDepth(2u),
          "rtContextSetMaxCallableProgramDepth(context, 2)");
    CALLS(context->getMaxCallableProgramDepth(),
          "rtContextGetMaxCallableProgramDepth(context, out)");
    CALLS(context->setMaxTraceDepth(2u), "rtContextSetMaxTraceDepth(context, 2)");
    CALLS(context->getMaxTraceDepth(), "rtContextGetMaxTraceDepth(context, out)");
    CALLS(context->setTimeoutCallback(0, 2.5), "rtContextSetTimeoutCallback(context, null, 2.5)");
    CALLS(context->setUsageReportCallback(0, 2, memory),
          "rtContextSetUsageReportCallback(context, null, 2, memory)");
    CALLS(context->setEntryPointCount(2u), "rtContextSetEntryPointCount(context, 2)");
    CALLS(context->getEntryPointCount(), "rtContextGetEntryPointCount(context, out)");
    CALLS(context->setRayTypeCount(2u), "rtContextSetRayTypeCount(context, 2)");
    CALLS(context->getRayTypeCount(), "rtContextGetRayTypeCount(context, out)");
    CALLS(context->setRayGenerationProgram(2u, program),
          "rtContextSetRayGenerationProgram(context, 2, program)");
    CALLS(context->getRayGenerationProgram(2u),
          "rtContextGetRayGenerationProgram(context, 2, out)");
    CALLS(context->setExceptionProgram(2u, program),
          "rtContextSetExceptionProgram(context, 2, program)");
    CALLS(context->getExceptionProgram(2u), "rtContextGetExceptionProgram(context, 2, out)");
    CALLS(context->setExceptionEnabled(static_cast<RTexception>(2), true),
          "rtContextSetExceptionEnabled(context, 2, 1)");
    CALLS(context->getExceptionEnabled(static_cast<RTexception>(2)),
          "rtContextGetExceptionEnabled(context, 2, out)");
    CALLS(context->setMissProgram(2u, program), "rtContextSetMissProgram(context, 2, program)");
    CALLS(context->getMissProgram(2u), "rtContextGetMissProgram(context, 2, out)");
    CALLS(context->launch(2u, 3u), "rtContextLaunch1D(context, 2, 3)");
    CALLS(context->launch(2u, 3u, 4u), "rtContextLaunch2D(context, 2, 3, 4)");
    CALLS(context->launch(2u, 3u, 4u, 5u), "rtContextLaunch3D(context, 2, 3, 4, 5)");
    CALLS(context->launchProgressive(2u, 3u, 4u, 5u),
          "rtContextLaunchProgressive2D(context, 2, 3, 4, 5)");
    CALLS(context->stopProgressive(), "rtContextStopProgressive(context)");
    CALLS(context->setPrintEnabled(true), "rtContextSetPrintEnabled(context, 1)");
    CALLS(context->getPrintEnabled(), "rtContextGetPrintEnabled(context, out)");
    CALLS(context->setPrintBufferSize(2u), "rtContextSetPrintBufferSize(context, 2)");
    CALLS(context->getPrintBufferSize(), "rtContextGetPrintBufferSize(context, out)");
    CALLS(context->setPrintLaunchIndex(2, 3, 4), "rtContextSetPrintLaunchIndex(context, 2, 3, 4)");
    CALLS(context->declareVariable("s2"), "rtContextDeclareVariable(context, s2, out)");
    CALLS(context->queryVariable("s2"), "rtContextQueryVariable(context, s2, out)");
    CALLS(context->removeVariable(variable), "rtContextRemoveVariable(context, variable)");
    CALLS(context->getVariableCount(), "rtContextGetVariableCount(context, out)");
    CALLS(context->getVariable(2u), "rtContextGetVariable(context, 2, out)");
}

TEST_F(OptixPpMembers, Program) {
    CALLS(program->declareVariable("s2"), "rtProgramDeclareVariable(program, s2, out)");
    CALLS(program->queryVariable("s2"), "rtProgramQueryVariable(program, s2, out)");
    CALLS(program->removeVariable(variable), "rtProgramRemoveVariable(program, variable)");
    CALLS(program->getVariableCount(), "rtProgramGetVariableCount(program, out)");
    CALLS(program->getVariable(2u), "rtProgramGetVariable(program, 2, out)");
    CALLS(program->setCallsitePotentialCallees("s2", std::vector<int>(3)),
          "rtProgramCallsiteSetPotentialCallees(program, s2, input, 3)");
    CALLS(program->getId(), "rtProgramGetId(program, out)");
}

TEST_F(OptixPpMembers, Group) {
    CALLS(group->setAcceleration(acceleration), "rtGroupSetAcceleration(group, acceleration)");
    CALLS(group->getAcceleration(), "rtGroupGetAcceleration(group, out)");
    CALLS(group->setChildCount(2u), "rtGroupSetChildCount(group, 2)");
    CALLS(group->getChildCount(), "rtGroupGetChildCount(group, out)");
    CALLS(group->getChildType(2u), "rtGroupGetChildType(group, 2, out)");
    CALLS(group->setVisibilityMask(2u), "rtGroupSetVisibilityMask(group, 2)");
    CALLS(group->getVisibilityMask(), "rtGroupGetVisibilityMask(group, out)");
}

TEST_F(OptixPpMembers, GeometryGroup) {
    CALLS(geometryGroup->setAcceleration(acceleration),
          "rtGeometryGroupSetAcceleration(geometryGroup, acceleration)");
    CALLS(geometryGroup->getAcceleration(), "rtGeometryGroupGetAcceleration(geometryGroup, out)");
    CALLS(geometryGroup->setChildCount(2u), "rtGeometryGroupSetChildCount(geometryGroup, 2)");
    CALLS(geometryGroup->getChildCount(), "rtGeometryGroupGetChildCount(geometryGroup, out)");
    CALLS(geometryGroup->setChild(2u, instance),
          "rtGeometryGroupSetChild(geometryGroup, 2, instance)");
    CALLS(geometryGroup->getChild(2u), "rtGeometryGroupGetChild(geometryGroup, 2, out)");
    CALLS(geometryGroup->setFlags(static_cast<RTinstanceflags>(2)),
          "rtGeometryGroupSetFlags(geometryGroup, 2)");
    CALLS(geometryGroup->getFlags(), "rtGeometryGroupGetFlags(geometryGroup, out)");
    CALLS(geometryGroup->setVisibilityMask(2u),
          "rtGeometryGroupSetVisibilityMask(geometryGroup, 2)");
    CALLS(geometryGroup->getVisibilityMask(),
          "rtGeometryGroupGetVisibilityMask(geometryGroup, out)");
}

TEST_F(OptixPpMembers, Transform) {
    CALLS(transform->getChildType(), "rtTransformGetChildType(transform, out)");
    CALLS(transform->setMatrix(true, input<float>(), input<float>()),
          "rtTransformSetMatrix(transform, 1, input, input)");
    CALLS(transform->getMatrix(true, &out<float>(), &out<float>()),
          "rtTransformGetMatrix(transform, 1, out, out)");
    CALLS(transform->setMotionRange(2.5f, 3.5f), "rtTransformSetMotionRange(transform, 2.5, 3.5)");
    CALLS(transform->getMotionRange(out<float>(), out<float>()),
          "rtTransformGetMotionRange(transform, out, out)");
    CALLS(transform->setMotionBorderMode(static_cast<RTmotionbordermode>(2),
                                         static_cast<RTmotionbordermode>(3)),
          "rtTransformSetMotionBorderMode(transform, 2, 3)");
    CALLS(transform->getMotionBorderMode(out<RTmotionbordermode>(), out<RTmotionbordermode>()),
          "rtTransformGetMotionBorderMode(transform, out, out)");
    CALLS(transform->setMotionKeys(2u, static_cast<RTmotionkeytype>(3), input<float>()),
          "rtTransformSetMotionKeys(transform, 2, 3, input)");
    CALLS(transform->getMotionKeyCount(), "rtTransformGetMotionKeyCount(transform, out)");
    CALLS(transform->getMotionKeyType(), "rtTransformGetMotionKeyType(transform, out)");
    CALLS(transform->getMotionKeys(&out<float>()), "rtTransformGetMotionKeys(transform, out)");
}

TEST_F(OptixPpMembers, Selector) {
    CALLS(selector->setVisitProgram(program), "rtSelectorSetVisitProgram(selector, program)");
    CALLS(selector->getVisitProgram(), "rtSelectorGetVisitProgram(selector, out)");
    CALLS(selector->setChildCount(2u), "rtSelectorSetChildCount(selector, 2)");
    CALLS(selector->getChildCount(), "rtSelectorGetChildCount(selector, out)");
    CALLS(selector->getChildType(2u), "rtSelectorGetChildType(selector, 2, out)");
    CALLS(selector->declareVariable("s2"), "rtSelectorDeclareVariable(selector, s2, out)");
    CALLS(selector->queryVariable("s2"), "rtSelectorQueryVariable(selector, s2, out)");
    CALLS(selector->removeVariable(variable), "rtSelectorRemoveVariable(selector, variable)");
    CALLS(selector->getVariableCount(), "rtSelectorGetVariableCount(selector, out)");
    CALLS(selector->getVariable(2u), "rtSelectorGetVariable(selector, 2, out)");
}

TEST_F(OptixPpMembers, Acceleration) {
    CALLS(acceleration->markDirty(), "rtAccelerationMarkDirty(acceleration)");
    CALLS(acceleration->isDirty(), "rtAccelerationIsDirty(acceleration, out)");
    CALLS(acceleration->setProperty("s2", "s3"), "rtAccelerationSetProperty(acceleration, s2, s3)");
    CALLS(acceleration->getProperty("s2"), "rtAccelerationGetProperty(acceleration, s2, out)");
    CALLS(acceleration->setBuilder("s2"), "rtAccelerationSetBuilder(acceleration, s2)");
    CALLS(acceleration->getBuilder(), "rtAccelerationGetBuilder(acceleration, out)");
    CALLS(acceleration->setTraverser("s2"), "rtAccelerationSetTraverser(acceleration, s2)");
    CALLS(acceleration->getTraverser(), "rtAccelerationGetTraverser(acceleration, out)");
    CALLS(acceleration->getDataSize(), "rtAccelerationGetDataSize(acceleration, out)");
    CALLS(acceleration->getData(memory), "rtAccelerationGetData(acceleration, memory)");
    CALLS(acceleration->setData(memory, 2u), "rtAccelerationSetData(acceleration, memory, 2)");
}

TEST_F(OptixPpMembers, GeometryInstance) {
    CALLS(instance->setGeometry(geometry), "rtGeometryInstanceSetGeometry(instance, geometry)");
    CALLS(instance->getGeometry(), "rtGeometryInstanceGetGeometry(instance, out)");
    CALLS(instance->setGeometryTriangles(triangles),
          "rtGeometryInstanceSetGeometryTriangles(instance, triangles)");
    CALLS(instance->getGeometryTriangles(),
          "rtGeometryInstanceGetGeometryTriangles(instance, out)");
    CALLS(instance->setMaterialCount(2u), "rtGeometryInstanceSetMaterialCount(instance, 2)");
    CALLS(instance->getMaterialCount(), "rtGeometryInstanceGetMaterialCount(instance, out)");
    CALLS(instance->setMaterial(2u, material),
          "rtGeometryInstanceSetMaterial(instance, 2, material)");
    CALLS(instance->getMaterial(2u), "rtGeometryInstanceGetMaterial(instance, 2, out)");
    CALLS(instance->declareVariable("s2"), "rtGeometryInstanceDeclareVariable(instance, s2, out)");
    CALLS(instance->queryVariable("s2"), "rtGeometryInstanceQueryVariable(instance, s2, out)");
    CALLS(instance->removeVariable(variable),
          "rtGeometryInstanceRemoveVariable(instance, variable)");
    CALLS(instance->getVariableCount(), "rtGeometryInstanceGetVariableCount(instance, out)");
    CALLS(instance->getVariable(2u), "rtGeometryInstanceGetVariable(instance, 2, out)");
}

TEST_F(OptixPpMembers, Geometry) {
    CALLS(geometry->markDirty(), "rtGeometryMarkDirty(geometry)");
    CALLS(geometry->isDirty(), "rtGeometryIsDirty(geometry, out)");
    CALLS(geometry->setPrimitiveCount(2u), "rtGeometrySetPrimitiveCount(geometry, 2)");
    CALLS(geometry->getPrimitiveCount(), "rtGeometryGetPrimitiveCount(geometry, out)");
    CALLS(geometry->setPrimitiveIndexOffset(2u), "rtGeometrySetPrimitiveIndexOffset(geometry, 2)");
    CALLS(geometry->getPrimitiveIndexOffset(), "rtGeometryGetPrimitiveIndexOffset(geometry, out)");
    CALLS(geometry->setMotionRange(2.5f, 3.5f), "rtGeometrySetMotionRange(geometry, 2.5, 3.5)");
    CALLS(geometry->getMotionRange(out<float>(), out<float>()),
          "rtGeometryGetMotionRange(geometry, out, out)");
    CALLS(geometry->setMotionBorderMode(static_cast<RTmotionbordermode>(2),
                                        static_cast<RTmotionbordermode>(3)),
          "rtGeometrySetMotionBorderMode(geometry, 2, 3)");
    CALLS(geometry->getMotionBorderMode(out<RTmotionbordermode>(), out<RTmotionbordermode>()),
          "rtGeometryGetMotionBorderMode(geometry, out, out)");
    CALLS(geometry->setMotionSteps(2u), "rtGeometrySetMotionSteps(geometry, 2)");
    CALLS(geometry->getMotionSteps(), "rtGeometryGetMotionSteps(geometry, out)");
    CALLS(geometry->setBoundingBoxProgram(program),
          "rtGeometrySetBoundingBoxProgram(geometry, program)");
    CALLS(geometry->getBoundingBoxProgram(), "rtGeometryGetBoundingBoxProgram(geometry, out)");
    CALLS(geometry->setIntersectionProgram(program),
          "rtGeometrySetIntersectionProgram(geometry, program)");
    CALLS(geometry->getIntersectionProgram(), "rtGeometryGetIntersectionProgram(geometry, out)");
    CALLS(geometry->setFlags(static_cast<RTgeometryflags>(2)), "rtGeometrySetFlags(geometry, 2)");
    CALLS(geometry->getFlags(), "rtGeometryGetFlags(geometry, out)");
    CALLS(geometry->declareVariable("s2"), "rtGeometryDeclareVariable(geometry, s2, out)");
    CALLS(geometry->queryVariable("s2"), "rtGeometryQueryVariable(geometry, s2, out)");
    CALLS(geometry->removeVariable(variable), "rtGeometryRemoveVariable(geometry, variable)");
    CALLS(geometry->getVariableCount(), "rtGeometryGetVariableCount(geometry, out)");
    CALLS(geometry->getVariable(2u), "rtGeometryGetVariable(geometry, 2, out)");
}

TEST_F(OptixPpMembers, GeometryTriangles) {
    CALLS(triangles->setPrimitiveIndexOffset(2u),
          "rtGeometryTrianglesSetPrimitiveIndexOffset(triangles, 2)");
    CALLS(triangles->getPrimitiveIndexOffset(),
          "rtGeometryTrianglesGetPrimitiveIndexOffset(triangles, out)");
    CALLS(triangles->setPrimitiveCount(2u), "rtGeometryTrianglesSetPrimitiveCount(triangles, 2)");
    CALLS(triangles->getPrimitiveCount(), "rtGeometryTrianglesGetPrimitiveCount(triangles, out)");
    CALLS(triangles->setPreTransformMatrix(true, input<float>()),
          "rtGeometryTrianglesSetPreTransformMatrix(triangles, 1, input)");
    CALLS(triangles->getPreTransformMatrix(true, &out<float>()),
          "rtGeometryTrianglesGetPreTransformMatrix(triangles, 1, out)");
    CALLS(triangles->setTriangleIndices(buffer, 2u, 3u, static_cast<RTformat>(4)),
          "rtGeometryTrianglesSetTriangleIndices(triangles, buffer, 2, 3, 4)");
    CALLS(triangles->setVertices(2u, buffer, 3u, 4u, static_cast<RTformat>(5)),
          "rtGeometryTrianglesSetVertices(triangles, 2, buffer, 3, 4, 5)");
    CALLS(triangles->setMotionVertices(2u, buffer, 3u, 4u, 5u, static_cast<RTformat>(6)),
          "rtGeometryTrianglesSetMotionVertices(triangles, 2, buffer, 3, 4, 5, 6)");
    CALLS(triangles->setMotionRange(2.5f, 3.5f),
          "rtGeometryTrianglesSetMotionRange(triangles, 2.5, 3.5)");
    CALLS(triangles->getMotionRange(out<float>(), out<float>()),
          "rtGeometryTrianglesGetMotionRange(triangles, out, out)");
    CALLS(triangles->setMotionBorderMode(static_cast<RTmotionbordermode>(2),
                                         static_cast<RTmotionbordermode>(3)),
          "rtGeometryTrianglesSetMotionBorderMode(triangles, 2, 3)");
    CALLS(triangles->getMotionBorderMode(out<RTmotionbordermode>(), out<RTmotionbordermode>()),
          "rtGeometryTrianglesGetMotionBorderMode(triangles, out, out)");
    CALLS(triangles->setMotionSteps(2u), "rtGeometryTrianglesSetMotionSteps(triangles, 2)");
    CALLS(triangles->getMotionSteps(), "rtGeometryTrianglesGetMotionSteps(triangles, out)");
    CALLS(triangles->setBuildFlags(static_cast<RTgeometrybuildflags>(2)),
          "rtGeometryTrianglesSetBuildFlags(triangles, 2)");
    CALLS(triangles->setMaterialCount(2u), "rtGeometryTrianglesSetMaterialCount(triangles, 2)");
    CALLS(triangles->getMaterialCount(), "rtGeometryTrianglesGetMaterialCount(triangles, out)");
    CALLS(triangles->setMaterialIndices(buffer, 2u, 3u, static_cast<RTformat>(4)),
          "rtGeometryTrianglesSetMaterialIndices(triangles, buffer, 2, 3, 4)");
    CALLS(triangles->setFlagsPerMaterial(2u, static_cast<RTgeometryflags>(3)),
          "rtGeometryTrianglesSetFlagsPerMaterial(triangles, 2, 3)");
    CALLS(triangles->getFlagsPerMaterial(2u),
          "rtGeometryTrianglesGetFlagsPerMaterial(triangles, 2, out)");
    CALLS(triangles->setAttributeProgram(program),
          "rtGeometryTrianglesSetAttributeProgram(triangles, program)");
    CALLS(triangles->getAttributeProgram(),
          "rtGeometryTrianglesGetAttributeProgram(triangles, out)");
    CALLS(triangles->declareVariable("s2"),
          "rtGeometryTrianglesDeclareVariable(triangles, s2, out)");
    CALLS(triangles->queryVariable("s2"), "rtGeometryTrianglesQueryVariable(triangles, s2, out)");
    CALLS(triangles->removeVariable(variable),
          "rtGeometryTrianglesRemoveVariable(triangles, variable)");
    CALLS(triangles->getVariableCount(), "rtGeometryTrianglesGetVariableCount(triangles, out)");
    CALLS(triangles->getVariable(2u), "rtGeometryTrianglesGetVariable(triangles, 2, out)");
}

TEST_F(OptixPpMembers, Material) {
    CALLS(material->setClosestHitProgram(2u, program),
          "rtMaterialSetClosestHitProgram(material, 2, program)");
    CALLS(material->getClosestHitProgram(2u), "rtMaterialGetClosestHitProgram(material, 2, out)");
    CALLS(material->setAnyHitProgram(2u, program),
          "rtMaterialSetAnyHitProgram(material, 2, program)");
    CALLS(material->getAnyHitProgram(2u), "rtMaterialGetAnyHitProgram(material, 2, out)");
    CALLS(material->declareVariable("s2"), "rtMaterialDeclareVariable(material, s2, out)");
    CALLS(material->queryVariable("s2"), "rtMaterialQueryVariable(material, s2, out)");
    CALLS(material->removeVariable(variable), "rtMaterialRemoveVariable(material, variable)");
    CALLS(material->getVariableCount(), "rtMaterialGetVariableCount(material, out)");
    CALLS(material->getVariable(2u), "rtMaterialGetVariable(material, 2, out)");
}

TEST_F(OptixPpMembers, Buffer) {
    CALLS(buffer->setFormat(static_cast<RTformat>(2)), "rtBufferSetFormat(buffer, 2)");
    CALLS(buffer->getFormat(), "rtBufferGetFormat(buffer, out)");
    CALLS(buffer->setElementSize(2u), "rtBufferSetElementSize(buffer, 2)");
    CALLS(buffer->getElementSize(), "rtBufferGetElementSize(buffer, out)");
    CALLS(buffer->getDevicePointer(2, &pointer), "rtBufferGetDevicePointer(buffer, 2, out)");
    CALLS(buffer->setDevicePointer(2, memory), "rtBufferSetDevicePointer(buffer, 2, memory)");
    CALLS(buffer->markDirty(), "rtBufferMarkDirty(buffer)");
    CALLS(buffer->setSize(2u), "rtBufferSetSize1D(buffer, 2)");
    CALLS(buffer->getSize(out<RTsize>()), "rtBufferGetSize1D(buffer, out)");
    CALLS(buffer->getMipLevelSize(2u, out<RTsize>()), "rtBufferGetMipLevelSize1D(buffer, 2, out)");
    CALLS(buffer->setSize(2u, 3u), "rtBufferSetSize2D(buffer, 2, 3)");
    CALLS(buffer->getSize(out<RTsize>(), out<RTsize>()), "rtBufferGetSize2D(buffer, out, out)");
    CALLS(buffer->getMipLevelSize(2u, out<RTsize>(), out<RTsize>()),
          "rtBufferGetMipLevelSize2D(buffer, 2, out, out)");
    CALLS(buffer->setSize(2u, 3u, 4u), "rtBufferSetSize3D(buffer, 2, 3, 4)");
    CALLS(buffer->getSize(out<RTsize>(), out<RTsize>(), out<RTsize>()),
          "rtBufferGetSize3D(buffer, out, out, out)");
    CALLS(buffer->getMipLevelSize(2u, out<RTsize>(), out<RTsize>(), out<RTsize>()),
          "rtBufferGetMipLevelSize3D(buffer, 2, out, out, out)");
    CALLS(buffer->setSize(2u, input<RTsize>()), "rtBufferSetSizev(buffer, 2, input)");
    CALLS(buffer->getSize(2u, &out<RTsize>()), "rtBufferGetSizev(buffer, 2, out)");
    CALLS(buffer->getDimensionality(), "rtBufferGetDimensionality(buffer, out)");
    CALLS(buffer->setMipLevelCount(2u), "rtBufferSetMipLevelCount(buffer, 2)");
    CALLS(buffer->getMipLevelCount(), "rtBufferGetMipLevelCount(buffer, out)");
    CALLS(buffer->getId(), "rtBufferGetId(buffer, out)");
    CALLS(buffer->getGLBOId(), "rtBufferGetGLBOId(buffer, out)");
    CALLS(buffer->registerGLBuffer(), "rtBufferGLRegister(buffer)");
    CALLS(buffer->unregisterGLBuffer(), "rtBufferGLUnregister(buffer)");
    CALLS(buffer->setAttribute(static_cast<RTbufferattribute>(2), 3u, memory),
          "rtBufferSetAttribute(buffer, 2, 3, memory)");
    CALLS(buffer->getAttribute(static_cast<RTbufferattribute>(2), 3u, memory),
          "rtBufferGetAttribute(buffer, 2, 3, memory)");
    CALLS(buffer->unmap(2u), "rtBufferUnmapEx(buffer, 2)");
    CALLS(buffer->bindProgressiveStream(buffer), "rtBufferBindProgressiveStream(buffer, buffer)");
    CALLS(
        buffer->getProgressiveUpdateReady(&out<int>(), &out<unsigned int>(), &out<unsigned int>()),
        "rtBufferGetProgressiveUpdateReady(buffer, out, out, out)");
}

TEST_F(OptixPpMembers, TextureSampler) {
    CALLS(sampler->setMipLevelCount(2u), "rtTextureSamplerSetMipLevelCount(sampler, 2)");
    CALLS(sampler->getMipLevelCount(), "rtTextureSamplerGetMipLevelCount(sampler, out)");
    CALLS(sampler->setArraySize(2u), "rtTextureSamplerSetArraySize(sampler, 2)");
    CALLS(sampler->getArraySize(), "rtTextureSamplerGetArraySize(sampler, out)");
    CALLS(sampler->setWrapMode(2u, static_cast<RTwrapmode>(3)),
          "rtTextureSamplerSetWrapMode(sampler, 2, 3)");
    CALLS(sampler->getWrapMode(2u), "rtTextureSamplerGetWrapMode(sampler, 2, out)");
    CALLS(sampler->setFilteringModes(static_cast<RTfiltermode>(2), static_cast<RTfiltermode>(3),
                                     static_cast<RTfiltermode>(4)),
          "rtTextureSamplerSetFilteringModes(sampler, 2, 3, 4)");
    CALLS(sampler->getFilteringModes(out<RTfiltermode>(), out<RTfiltermode>(), out<RTfiltermode>()),
          "rtTextureSamplerGetFilteringModes(sampler, out, out, out)");
    CALLS(sampler->setMaxAnisotropy(2.5f), "rtTextureSamplerSetMaxAnisotropy(sampler, 2.5)");
    CALLS(sampler->getMaxAnisotropy(), "rtTextureSamplerGetMaxAnisotropy(sampler, out)");
    CALLS(sampler->setMipLevelClamp(2.5f, 3.5f),
          "rtTextureSamplerSetMipLevelClamp(sampler, 2.5, 3.5)");
    CALLS(sampler->getMipLevelClamp(out<float>(), out<float>()),
          "rtTextureSamplerGetMipLevelClamp(sampler, out, out)");
    CALLS(sampler->setMipLevelBias(2.5f), "rtTextureSamplerSetMipLevelBias(sampler, 2.5)");
    CALLS(sampler->getMipLevelBias(), "rtTextureSamplerGetMipLevelBias(sampler, out)");
    CALLS(sampler->setReadMode(static_cast<RTtexturereadmode>(2)),
          "rtTextureSamplerSetReadMode(sampler, 2)");
    CALLS(sampler->getReadMode(), "rtTextureSamplerGetReadMode(sampler, out)");
    CALLS(sampler->setIndexingMode(static_cast<RTtextureindexmode>(2)),
          "rtTextureSamplerSetIndexingMode(sampler, 2)");
    CALLS(sampler->getIndexingMode(), "rtTextureSamplerGetIndexingMode(sampler, out)");
    CALLS(sampler->getId(), "rtTextureSamplerGetId(sampler, out)");
    CALLS(sampler->setBuffer(2u, 3u, buffer), "rtTextureSamplerSetBuffer(sampler, 2, 3, buffer)");
    CALLS(sampler->getBuffer(2u, 3u), "rtTextureSamplerGetBuffer(sampler, 2, 3, out)");
    CALLS(sampler->registerGLTexture(), "rtTextureSamplerGLRegister(sampler)");
    CALLS(sampler->unregisterGLTexture(), "rtTextureSamplerGLUnregister(sampler)");
}

TEST_F(OptixPpMembers, PostprocessingStage) {
    CALLS(stage->declareVariable("s2"), "rtPostProcessingStageDeclareVariable(stage, s2, out)");
    CALLS(stage->queryVariable("s2"), "rtPostProcessingStageQueryVariable(stage, s2, out)");
    CALLS(stage->getVariableCount(), "rtPostProcessingStageGetVariableCount(stage, out)");
    CALLS(stage->getVariable(2u), "rtPostProcessingStageGetVariable(stage, 2, out)");
}

TEST_F(OptixPpMembers, CommandList) {
    CALLS(list->appendPostprocessingStage(stage, 2u, 3u),
          "rtCommandListAppendPostprocessingStage(list, stage, 2, 3)");
    CALLS(list->appendLaunch(2u, 3u, 4u), "rtCommandListAppendLaunch2D(list, 2, 3, 4)");
    CALLS(list->finalize(), "rtCommandListFinalize(list)");
    CALLS(list->execute(), "rtCommandListExecute(list)");
}
