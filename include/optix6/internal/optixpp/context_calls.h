// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API: the member functions of context.h.
#ifndef SUNSTONE_OPTIXPP_CONTEXT_CALLS_H
#define SUNSTONE_OPTIXPP_CONTEXT_CALLS_H

#include "calls.h"

namespace optix {

// ---- Context ----------------------------------------------------------------------------------

// The call destroys the context even if it reports the failure of an earlier launch.
inline void ContextObj::destroy() {
    const RTcontext context = m_context;
    m_context = 0;
    internal::check(rtContextDestroy(context));
}
inline void ContextObj::validate() {
    checkError(rtContextValidate(m_context));
}
inline Context ContextObj::getContext() const {
    return Context::take(m_context);
}
inline RTcontext ContextObj::get() {
    return m_context;
}
inline unsigned int ContextObj::getDeviceCount() {
    unsigned int count = 0;
    internal::check(rtDeviceGetDeviceCount(&count));
    return count;
}
inline std::string ContextObj::getDeviceName(int ordinal) {
    char name[512] = {};
    internal::check(rtDeviceGetAttribute(ordinal, RT_DEVICE_ATTRIBUTE_NAME, sizeof(name), name));
    return name;
}
inline std::string ContextObj::getDevicePCIBusId(int ordinal) {
    char id[16] = {};
    internal::check(rtDeviceGetAttribute(ordinal, RT_DEVICE_ATTRIBUTE_PCI_BUS_ID, sizeof(id), id));
    return id;
}
inline void ContextObj::getDeviceAttribute(int ordinal, RTdeviceattribute attrib, RTsize size,
                                           void* p) {
    internal::check(rtDeviceGetAttribute(ordinal, attrib, size, p));
}
inline std::vector<int> ContextObj::getCompatibleDevices(int ordinal) {
    std::vector<int> list(getDeviceCount() + 1);
    internal::check(rtDeviceGetAttribute(ordinal, RT_DEVICE_ATTRIBUTE_COMPATIBLE_DEVICES,
                                         sizeof(int) * list.size(), list.data()));
    const std::vector<int>::size_type count = static_cast<std::vector<int>::size_type>(list[0]);
    list.erase(list.begin());
    if (count < list.size())
        list.resize(count);
    return list;
}
inline Context ContextObj::create() {
    RTcontext context = 0;
    internal::check(rtContextCreate(&context));
    return Context::take(context);
}
inline void ContextObj::checkError(RTresult code) const {
    internal::check(code, m_context);
}
inline std::string ContextObj::getErrorString(RTresult code) const {
    const char* text = 0;
    rtContextGetErrorString(m_context, code, &text);
    return text ? text : "";
}
inline void ContextObj::compile() {
    checkError(rtContextCompile(m_context));
}
inline int ContextObj::getRunningState() const {
    int value = 0;
    checkError(rtContextGetRunningState(m_context, &value));
    return value;
}
inline Acceleration ContextObj::createAcceleration(const std::string& builder,
                                                   const std::string& ignored) {
    (void)ignored;
    RTacceleration acceleration = 0;
    checkError(rtAccelerationCreate(m_context, &acceleration));
    const Acceleration result = Acceleration::take(acceleration);
    checkError(rtAccelerationSetBuilder(acceleration, builder.c_str()));
    return result;
}
inline Buffer ContextObj::createBuffer(unsigned int type) {
    RTbuffer value = 0;
    checkError(rtBufferCreate(m_context, type, &value));
    return Buffer::take(value);
}
inline Buffer ContextObj::createBuffer(unsigned int type, RTformat format) {
    Buffer result = createBuffer(type);
    result->setFormat(format);
    return result;
}
inline Buffer ContextObj::createBuffer(unsigned int type, RTformat format, RTsize width) {
    Buffer result = createBuffer(type, format);
    result->setSize(width);
    return result;
}
inline Buffer ContextObj::createBuffer(unsigned int type, RTformat format, RTsize width,
                                       RTsize height) {
    Buffer result = createBuffer(type, format);
    result->setSize(width, height);
    return result;
}
inline Buffer ContextObj::createBuffer(unsigned int type, RTformat format, RTsize width,
                                       RTsize height, RTsize depth) {
    Buffer result = createBuffer(type, format);
    result->setSize(width, height, depth);
    return result;
}
inline Buffer ContextObj::createMipmappedBuffer(unsigned int type, RTformat format, RTsize width,
                                                unsigned int levels) {
    Buffer result = createBuffer(type, format, width);
    result->setMipLevelCount(levels);
    return result;
}
inline Buffer ContextObj::createMipmappedBuffer(unsigned int type, RTformat format, RTsize width,
                                                RTsize height, unsigned int levels) {
    Buffer result = createBuffer(type, format, width, height);
    result->setMipLevelCount(levels);
    return result;
}
inline Buffer ContextObj::createMipmappedBuffer(unsigned int type, RTformat format, RTsize width,
                                                RTsize height, RTsize depth, unsigned int levels) {
    Buffer result = createBuffer(type, format, width, height, depth);
    result->setMipLevelCount(levels);
    return result;
}
inline Buffer ContextObj::create1DLayeredBuffer(unsigned int type, RTformat format, RTsize width,
                                                RTsize layers, unsigned int levels) {
    return createMipmappedBuffer(type | RT_BUFFER_LAYERED, format, width, 1, layers, levels);
}
inline Buffer ContextObj::create2DLayeredBuffer(unsigned int type, RTformat format, RTsize width,
                                                RTsize height, RTsize layers, unsigned int levels) {
    return createMipmappedBuffer(type | RT_BUFFER_LAYERED, format, width, height, layers, levels);
}
inline Buffer ContextObj::createCubeBuffer(unsigned int type, RTformat format, RTsize width,
                                           RTsize height, unsigned int levels) {
    return createMipmappedBuffer(type | RT_BUFFER_CUBEMAP, format, width, height, 6, levels);
}
inline Buffer ContextObj::createCubeLayeredBuffer(unsigned int type, RTformat format, RTsize width,
                                                  RTsize height, RTsize faces,
                                                  unsigned int levels) {
    return createMipmappedBuffer(type | RT_BUFFER_LAYERED | RT_BUFFER_CUBEMAP, format, width,
                                 height, faces, levels);
}
inline Buffer ContextObj::createBufferForCUDA(unsigned int type) {
    RTbuffer value = 0;
    checkError(rtBufferCreateForCUDA(m_context, type, &value));
    return Buffer::take(value);
}
inline Buffer ContextObj::createBufferForCUDA(unsigned int type, RTformat format) {
    Buffer result = createBufferForCUDA(type);
    result->setFormat(format);
    return result;
}
inline Buffer ContextObj::createBufferForCUDA(unsigned int type, RTformat format, RTsize width) {
    Buffer result = createBufferForCUDA(type, format);
    result->setSize(width);
    return result;
}
inline Buffer ContextObj::createBufferForCUDA(unsigned int type, RTformat format, RTsize width,
                                              RTsize height) {
    Buffer result = createBufferForCUDA(type, format);
    result->setSize(width, height);
    return result;
}
inline Buffer ContextObj::createBufferForCUDA(unsigned int type, RTformat format, RTsize width,
                                              RTsize height, RTsize depth) {
    Buffer result = createBufferForCUDA(type, format);
    result->setSize(width, height, depth);
    return result;
}
inline Buffer ContextObj::createBufferFromGLBO(unsigned int type, unsigned int vbo) {
    RTbuffer value = 0;
    checkError(rtBufferCreateFromGLBO(m_context, type, vbo, &value));
    return Buffer::take(value);
}
inline TextureSampler ContextObj::createTextureSamplerFromGLImage(unsigned int id,
                                                                  RTgltarget target) {
    RTtexturesampler value = 0;
    checkError(rtTextureSamplerCreateFromGLImage(m_context, id, target, &value));
    return TextureSampler::take(value);
}
inline Buffer ContextObj::getBufferFromId(int buffer_id) {
    RTbuffer value = 0;
    checkError(rtContextGetBufferFromId(m_context, buffer_id, &value));
    return Buffer::take(value);
}
inline Program ContextObj::getProgramFromId(int program_id) {
    RTprogram value = 0;
    checkError(rtContextGetProgramFromId(m_context, program_id, &value));
    return Program::take(value);
}
inline TextureSampler ContextObj::getTextureSamplerFromId(int sampler_id) {
    RTtexturesampler value = 0;
    checkError(rtContextGetTextureSamplerFromId(m_context, sampler_id, &value));
    return TextureSampler::take(value);
}
inline Geometry ContextObj::createGeometry() {
    RTgeometry value = 0;
    checkError(rtGeometryCreate(m_context, &value));
    return Geometry::take(value);
}
inline GeometryTriangles ContextObj::createGeometryTriangles() {
    RTgeometrytriangles value = 0;
    checkError(rtGeometryTrianglesCreate(m_context, &value));
    return GeometryTriangles::take(value);
}
inline GeometryInstance ContextObj::createGeometryInstance() {
    RTgeometryinstance value = 0;
    checkError(rtGeometryInstanceCreate(m_context, &value));
    return GeometryInstance::take(value);
}
template <class Iterator>
inline GeometryInstance ContextObj::createGeometryInstance(Geometry geometry, Iterator matlbegin,
                                                           Iterator matlend) {
    GeometryInstance result = createGeometryInstance();
    result->setGeometry(geometry);
    result->setMaterialCount(static_cast<unsigned int>(std::distance(matlbegin, matlend)));
    for (unsigned int i = 0; matlbegin != matlend; ++matlbegin, ++i)
        result->setMaterial(i, *matlbegin);
    return result;
}
inline GeometryInstance ContextObj::createGeometryInstance(GeometryTriangles geometry,
                                                           Material mat) {
    GeometryInstance result = createGeometryInstance();
    result->setGeometryTriangles(geometry);
    result->setMaterialCount(1);
    result->setMaterial(0, mat);
    return result;
}
inline Group ContextObj::createGroup() {
    RTgroup value = 0;
    checkError(rtGroupCreate(m_context, &value));
    return Group::take(value);
}
template <class Iterator>
inline Group ContextObj::createGroup(Iterator childbegin, Iterator childend) {
    Group result = createGroup();
    result->setChildCount(static_cast<unsigned int>(std::distance(childbegin, childend)));
    for (unsigned int i = 0; childbegin != childend; ++childbegin, ++i)
        result->setChild(i, *childbegin);
    return result;
}
inline GeometryGroup ContextObj::createGeometryGroup() {
    RTgeometrygroup value = 0;
    checkError(rtGeometryGroupCreate(m_context, &value));
    return GeometryGroup::take(value);
}
template <class Iterator>
inline GeometryGroup ContextObj::createGeometryGroup(Iterator childbegin, Iterator childend) {
    GeometryGroup result = createGeometryGroup();
    result->setChildCount(static_cast<unsigned int>(std::distance(childbegin, childend)));
    for (unsigned int i = 0; childbegin != childend; ++childbegin, ++i)
        result->setChild(i, *childbegin);
    return result;
}
inline Transform ContextObj::createTransform() {
    RTtransform value = 0;
    checkError(rtTransformCreate(m_context, &value));
    return Transform::take(value);
}
inline Material ContextObj::createMaterial() {
    RTmaterial value = 0;
    checkError(rtMaterialCreate(m_context, &value));
    return Material::take(value);
}
inline Program ContextObj::createProgramFromPTXFile(const std::string& filename,
                                                    const std::string& program_name) {
    RTprogram value = 0;
    checkError(
        rtProgramCreateFromPTXFile(m_context, filename.c_str(), program_name.c_str(), &value));
    return Program::take(value);
}
inline Program ContextObj::createProgramFromPTXFiles(const std::vector<std::string>& filenames,
                                                     const std::string& program_name) {
    return createProgramFromPTXFiles(internal::pointers(filenames), program_name);
}
inline Program ContextObj::createProgramFromPTXFiles(const std::vector<const char*>& filenames,
                                                     const std::string& program_name) {
    std::vector<const char*> list = filenames;
    RTprogram program = 0;
    checkError(rtProgramCreateFromPTXFiles(m_context, static_cast<unsigned int>(list.size()),
                                           list.data(), program_name.c_str(), &program));
    return Program::take(program);
}
inline Program ContextObj::createProgramFromPTXString(const std::string& ptx,
                                                      const std::string& program_name) {
    RTprogram value = 0;
    checkError(rtProgramCreateFromPTXString(m_context, ptx.c_str(), program_name.c_str(), &value));
    return Program::take(value);
}
inline Program ContextObj::createProgramFromPTXStrings(const std::vector<std::string>& ptxStrings,
                                                       const std::string& program_name) {
    return createProgramFromPTXStrings(internal::pointers(ptxStrings), program_name);
}
inline Program ContextObj::createProgramFromPTXStrings(const std::vector<const char*>& ptxStrings,
                                                       const std::string& program_name) {
    std::vector<const char*> list = ptxStrings;
    RTprogram program = 0;
    checkError(rtProgramCreateFromPTXStrings(m_context, static_cast<unsigned int>(list.size()),
                                             list.data(), program_name.c_str(), &program));
    return Program::take(program);
}
inline Selector ContextObj::createSelector() {
    RTselector value = 0;
    checkError(rtSelectorCreate(m_context, &value));
    return Selector::take(value);
}
inline TextureSampler ContextObj::createTextureSampler() {
    RTtexturesampler value = 0;
    checkError(rtTextureSamplerCreate(m_context, &value));
    return TextureSampler::take(value);
}
inline PostprocessingStage
ContextObj::createBuiltinPostProcessingStage(const std::string& builtin_name) {
    RTpostprocessingstage value = 0;
    checkError(rtPostProcessingStageCreateBuiltin(m_context, builtin_name.c_str(), &value));
    return PostprocessingStage::take(value);
}
inline CommandList ContextObj::createCommandList() {
    RTcommandlist value = 0;
    checkError(rtCommandListCreate(m_context, &value));
    return CommandList::take(value);
}
template <class Iterator>
inline void ContextObj::setDevices(Iterator begin, Iterator end) {
    const std::vector<int> devices(begin, end);
    checkError(
        rtContextSetDevices(m_context, static_cast<unsigned int>(devices.size()), devices.data()));
}
inline std::vector<int> ContextObj::getEnabledDevices() const {
    std::vector<int> devices(getEnabledDeviceCount());
    checkError(rtContextGetDevices(m_context, devices.data()));
    return devices;
}
inline unsigned int ContextObj::getEnabledDeviceCount() const {
    unsigned int value = 0;
    checkError(rtContextGetDeviceCount(m_context, &value));
    return value;
}
inline int ContextObj::getMaxTextureCount() const {
    return attributeOf<int>(RT_CONTEXT_ATTRIBUTE_MAX_TEXTURE_COUNT);
}
inline int ContextObj::getCPUNumThreads() const {
    return attributeOf<int>(RT_CONTEXT_ATTRIBUTE_CPU_NUM_THREADS);
}
inline RTsize ContextObj::getUsedHostMemory() const {
    return attributeOf<RTsize>(RT_CONTEXT_ATTRIBUTE_USED_HOST_MEMORY);
}
inline bool ContextObj::getPreferFastRecompiles() const {
    return attributeOf<int>(RT_CONTEXT_ATTRIBUTE_PREFER_FAST_RECOMPILES) != 0;
}
inline bool ContextObj::getForceInlineUserFunctions() const {
    return attributeOf<int>(RT_CONTEXT_ATTRIBUTE_FORCE_INLINE_USER_FUNCTIONS) != 0;
}
inline int ContextObj::getGPUPagingActive() const {
    return attributeOf<int>(RT_CONTEXT_ATTRIBUTE_GPU_PAGING_ACTIVE);
}
inline int ContextObj::getGPUPagingForcedOff() const {
    return attributeOf<int>(RT_CONTEXT_ATTRIBUTE_GPU_PAGING_FORCED_OFF);
}
inline RTsize ContextObj::getAvailableDeviceMemory(int ordinal) const {
    return attributeOf<RTsize>(
        static_cast<RTcontextattribute>(RT_CONTEXT_ATTRIBUTE_AVAILABLE_DEVICE_MEMORY + ordinal));
}
inline void ContextObj::setCPUNumThreads(int cpu_num_threads) {
    setAttribute(RT_CONTEXT_ATTRIBUTE_CPU_NUM_THREADS, cpu_num_threads);
}
inline void ContextObj::setPreferFastRecompiles(bool enabled) {
    setAttribute(RT_CONTEXT_ATTRIBUTE_PREFER_FAST_RECOMPILES, static_cast<int>(enabled));
}
inline void ContextObj::setForceInlineUserFunctions(bool enabled) {
    setAttribute(RT_CONTEXT_ATTRIBUTE_FORCE_INLINE_USER_FUNCTIONS, static_cast<int>(enabled));
}
inline void ContextObj::setDiskCacheLocation(const std::string& path) {
    const char* location = path.c_str();
    setAttribute(RT_CONTEXT_ATTRIBUTE_DISK_CACHE_LOCATION, location);
}
inline std::string ContextObj::getDiskCacheLocation() {
    const char* location = attributeOf<const char*>(RT_CONTEXT_ATTRIBUTE_DISK_CACHE_LOCATION);
    return location ? location : "";
}
inline void ContextObj::setDiskCacheMemoryLimits(RTsize lowWaterMark, RTsize highWaterMark) {
    const RTsize limits[2] = {lowWaterMark, highWaterMark};
    checkError(rtContextSetAttribute(m_context, RT_CONTEXT_ATTRIBUTE_DISK_CACHE_MEMORY_LIMITS,
                                     sizeof(limits), limits));
}
inline void ContextObj::getDiskCacheMemoryLimits(RTsize& lowWaterMark, RTsize& highWaterMark) {
    RTsize limits[2] = {};
    checkError(rtContextGetAttribute(m_context, RT_CONTEXT_ATTRIBUTE_DISK_CACHE_MEMORY_LIMITS,
                                     sizeof(limits), limits));
    lowWaterMark = limits[0];
    highWaterMark = limits[1];
}
inline void ContextObj::setGPUPagingForcedOff(int gpu_paging_forced_off) {
    setAttribute(RT_CONTEXT_ATTRIBUTE_GPU_PAGING_FORCED_OFF, gpu_paging_forced_off);
}
template <class T>
inline void ContextObj::setAttribute(RTcontextattribute attribute, const T& val) {
    checkError(rtContextSetAttribute(m_context, attribute, sizeof(val), &val));
}
inline void ContextObj::setStackSize(RTsize stack_size_bytes) {
    checkError(rtContextSetStackSize(m_context, stack_size_bytes));
}
inline RTsize ContextObj::getStackSize() const {
    RTsize value = 0;
    checkError(rtContextGetStackSize(m_context, &value));
    return value;
}
inline void ContextObj::setMaxCallableProgramDepth(unsigned int max_depth) {
    checkError(rtContextSetMaxCallableProgramDepth(m_context, max_depth));
}
inline unsigned int ContextObj::getMaxCallableProgramDepth() const {
    unsigned int value = 0;
    checkError(rtContextGetMaxCallableProgramDepth(m_context, &value));
    return value;
}
inline void ContextObj::setMaxTraceDepth(unsigned int max_depth) {
    checkError(rtContextSetMaxTraceDepth(m_context, max_depth));
}
inline unsigned int ContextObj::getMaxTraceDepth() const {
    unsigned int value = 0;
    checkError(rtContextGetMaxTraceDepth(m_context, &value));
    return value;
}
inline void ContextObj::setTimeoutCallback(RTtimeoutcallback callback, double min_polling_seconds) {
    checkError(rtContextSetTimeoutCallback(m_context, callback, min_polling_seconds));
}
inline void ContextObj::setUsageReportCallback(RTusagereportcallback callback, int verbosity,
                                               void* cbdata) {
    checkError(rtContextSetUsageReportCallback(m_context, callback, verbosity, cbdata));
}
inline void ContextObj::setEntryPointCount(unsigned int num_entry_points) {
    checkError(rtContextSetEntryPointCount(m_context, num_entry_points));
}
inline unsigned int ContextObj::getEntryPointCount() const {
    unsigned int value = 0;
    checkError(rtContextGetEntryPointCount(m_context, &value));
    return value;
}
inline void ContextObj::setRayTypeCount(unsigned int num_ray_types) {
    checkError(rtContextSetRayTypeCount(m_context, num_ray_types));
}
inline unsigned int ContextObj::getRayTypeCount() const {
    unsigned int value = 0;
    checkError(rtContextGetRayTypeCount(m_context, &value));
    return value;
}
inline void ContextObj::setRayGenerationProgram(unsigned int entry_point_index, Program program) {
    checkError(
        rtContextSetRayGenerationProgram(m_context, entry_point_index, internal::api(program)));
}
inline Program ContextObj::getRayGenerationProgram(unsigned int entry_point_index) const {
    RTprogram value = 0;
    checkError(rtContextGetRayGenerationProgram(m_context, entry_point_index, &value));
    return Program::take(value);
}
inline void ContextObj::setExceptionProgram(unsigned int entry_point_index, Program program) {
    checkError(rtContextSetExceptionProgram(m_context, entry_point_index, internal::api(program)));
}
inline Program ContextObj::getExceptionProgram(unsigned int entry_point_index) const {
    RTprogram value = 0;
    checkError(rtContextGetExceptionProgram(m_context, entry_point_index, &value));
    return Program::take(value);
}
inline void ContextObj::setExceptionEnabled(RTexception exception, bool enabled) {
    checkError(rtContextSetExceptionEnabled(m_context, exception, enabled));
}
inline bool ContextObj::getExceptionEnabled(RTexception exception) const {
    int value = 0;
    checkError(rtContextGetExceptionEnabled(m_context, exception, &value));
    return value != 0;
}
inline void ContextObj::setMissProgram(unsigned int ray_type_index, Program program) {
    checkError(rtContextSetMissProgram(m_context, ray_type_index, internal::api(program)));
}
inline Program ContextObj::getMissProgram(unsigned int ray_type_index) const {
    RTprogram value = 0;
    checkError(rtContextGetMissProgram(m_context, ray_type_index, &value));
    return Program::take(value);
}
inline void ContextObj::launch(unsigned int entry_point_index, RTsize image_width) {
    checkError(rtContextLaunch1D(m_context, entry_point_index, image_width));
}
inline void ContextObj::launch(unsigned int entry_point_index, RTsize image_width,
                               RTsize image_height) {
    checkError(rtContextLaunch2D(m_context, entry_point_index, image_width, image_height));
}
inline void ContextObj::launch(unsigned int entry_point_index, RTsize image_width,
                               RTsize image_height, RTsize image_depth) {
    checkError(
        rtContextLaunch3D(m_context, entry_point_index, image_width, image_height, image_depth));
}
inline void ContextObj::launchProgressive(unsigned int entry_point_index, RTsize image_width,
                                          RTsize image_height, unsigned int max_subframes) {
    checkError(rtContextLaunchProgressive2D(m_context, entry_point_index, image_width, image_height,
                                            max_subframes));
}
inline void ContextObj::stopProgressive() {
    checkError(rtContextStopProgressive(m_context));
}
inline void ContextObj::setRemoteDevice(RemoteDevice remote_dev) {
    checkError(rtContextSetRemoteDevice(m_context, internal::api(remote_dev)));
}
inline void ContextObj::setPrintEnabled(bool enabled) {
    checkError(rtContextSetPrintEnabled(m_context, enabled));
}
inline bool ContextObj::getPrintEnabled() const {
    int value = 0;
    checkError(rtContextGetPrintEnabled(m_context, &value));
    return value != 0;
}
inline void ContextObj::setPrintBufferSize(RTsize buffer_size_bytes) {
    checkError(rtContextSetPrintBufferSize(m_context, buffer_size_bytes));
}
inline RTsize ContextObj::getPrintBufferSize() const {
    RTsize value = 0;
    checkError(rtContextGetPrintBufferSize(m_context, &value));
    return value;
}
inline void ContextObj::setPrintLaunchIndex(int x, int y, int z) {
    checkError(rtContextSetPrintLaunchIndex(m_context, x, y, z));
}
inline optix::int3 ContextObj::getPrintLaunchIndex() const {
    optix::int3 result;
    checkError(rtContextGetPrintLaunchIndex(m_context, &result.x, &result.y, &result.z));
    return result;
}
inline Variable ContextObj::declareVariable(const std::string& name) {
    RTvariable value = 0;
    checkError(rtContextDeclareVariable(m_context, name.c_str(), &value));
    return Variable::take(value);
}
inline Variable ContextObj::queryVariable(const std::string& name) const {
    RTvariable value = 0;
    checkError(rtContextQueryVariable(m_context, name.c_str(), &value));
    return Variable::take(value);
}
inline void ContextObj::removeVariable(Variable v) {
    checkError(rtContextRemoveVariable(m_context, internal::api(v)));
}
inline unsigned int ContextObj::getVariableCount() const {
    unsigned int value = 0;
    checkError(rtContextGetVariableCount(m_context, &value));
    return value;
}
inline Variable ContextObj::getVariable(unsigned int index) const {
    RTvariable value = 0;
    checkError(rtContextGetVariable(m_context, index, &value));
    return Variable::take(value);
}
template <typename T>
inline T ContextObj::attributeOf(RTcontextattribute attribute) const {
    T value = T();
    checkError(rtContextGetAttribute(m_context, attribute, sizeof(value), &value));
    return value;
}

// ---- Program ----------------------------------------------------------------------------------

inline void ProgramObj::destroy() {
    checkError(rtProgramDestroy(m_program));
    m_program = 0;
}
inline void ProgramObj::validate() {
    checkError(rtProgramValidate(m_program));
}
inline Context ProgramObj::getContext() const {
    RTcontext context = 0;
    checkErrorNoGetContext(rtProgramGetContext(m_program, &context));
    return Context::take(context);
}
inline RTprogram ProgramObj::get() {
    return m_program;
}
inline Variable ProgramObj::declareVariable(const std::string& name) {
    RTvariable value = 0;
    checkError(rtProgramDeclareVariable(m_program, name.c_str(), &value));
    return Variable::take(value);
}
inline Variable ProgramObj::queryVariable(const std::string& name) const {
    RTvariable value = 0;
    checkError(rtProgramQueryVariable(m_program, name.c_str(), &value));
    return Variable::take(value);
}
inline void ProgramObj::removeVariable(Variable v) {
    checkError(rtProgramRemoveVariable(m_program, internal::api(v)));
}
inline unsigned int ProgramObj::getVariableCount() const {
    unsigned int value = 0;
    checkError(rtProgramGetVariableCount(m_program, &value));
    return value;
}
inline Variable ProgramObj::getVariable(unsigned int index) const {
    RTvariable value = 0;
    checkError(rtProgramGetVariable(m_program, index, &value));
    return Variable::take(value);
}
inline void ProgramObj::setCallsitePotentialCallees(const std::string& callSiteName,
                                                    const std::vector<int>& calleeIds) {
    checkError(rtProgramCallsiteSetPotentialCallees(
        m_program, callSiteName.c_str(), calleeIds.data(), static_cast<int>(calleeIds.size())));
}
inline int ProgramObj::getId() const {
    int value = 0;
    checkError(rtProgramGetId(m_program, &value));
    return value;
}

} // namespace optix

#endif
