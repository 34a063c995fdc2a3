// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API: the member functions of data.h.
#ifndef SUNSTONE_OPTIXPP_DATA_CALLS_H
#define SUNSTONE_OPTIXPP_DATA_CALLS_H

#include "calls.h"

namespace optix {

// ---- Buffer -----------------------------------------------------------------------------------

inline void BufferObj::destroy() {
    checkError(rtBufferDestroy(m_buffer));
    m_buffer = 0;
}
inline void BufferObj::validate() {
    checkError(rtBufferValidate(m_buffer));
}
inline Context BufferObj::getContext() const {
    RTcontext context = 0;
    checkErrorNoGetContext(rtBufferGetContext(m_buffer, &context));
    return Context::take(context);
}
inline RTbuffer BufferObj::get() {
    return m_buffer;
}
inline void BufferObj::setFormat(RTformat format) {
    checkError(rtBufferSetFormat(m_buffer, format));
}
inline RTformat BufferObj::getFormat() const {
    RTformat value = RTformat();
    checkError(rtBufferGetFormat(m_buffer, &value));
    return value;
}
inline void BufferObj::setElementSize(RTsize size_of_element) {
    checkError(rtBufferSetElementSize(m_buffer, size_of_element));
}
inline RTsize BufferObj::getElementSize() const {
    RTsize value = 0;
    checkError(rtBufferGetElementSize(m_buffer, &value));
    return value;
}
inline void BufferObj::getDevicePointer(int optix_device_ordinal, void** device_pointer) {
    checkError(rtBufferGetDevicePointer(m_buffer, optix_device_ordinal, device_pointer));
}
inline void* BufferObj::getDevicePointer(int optix_device_ordinal) {
    void* pointer = 0;
    getDevicePointer(optix_device_ordinal, &pointer);
    return pointer;
}
inline void BufferObj::setDevicePointer(int optix_device_ordinal, void* device_pointer) {
    checkError(rtBufferSetDevicePointer(m_buffer, optix_device_ordinal, device_pointer));
}
inline void BufferObj::markDirty() {
    checkError(rtBufferMarkDirty(m_buffer));
}
inline void BufferObj::setSize(RTsize width) {
    checkError(rtBufferSetSize1D(m_buffer, width));
}
inline void BufferObj::getSize(RTsize& width) const {
    checkError(rtBufferGetSize1D(m_buffer, &width));
}
inline void BufferObj::getMipLevelSize(unsigned int level, RTsize& width) const {
    checkError(rtBufferGetMipLevelSize1D(m_buffer, level, &width));
}
inline void BufferObj::setSize(RTsize width, RTsize height) {
    checkError(rtBufferSetSize2D(m_buffer, width, height));
}
inline void BufferObj::getSize(RTsize& width, RTsize& height) const {
    checkError(rtBufferGetSize2D(m_buffer, &width, &height));
}
inline void BufferObj::getMipLevelSize(unsigned int level, RTsize& width, RTsize& height) const {
    checkError(rtBufferGetMipLevelSize2D(m_buffer, level, &width, &height));
}
inline void BufferObj::setSize(RTsize width, RTsize height, RTsize depth) {
    checkError(rtBufferSetSize3D(m_buffer, width, height, depth));
}
inline void BufferObj::getSize(RTsize& width, RTsize& height, RTsize& depth) const {
    checkError(rtBufferGetSize3D(m_buffer, &width, &height, &depth));
}
inline void BufferObj::getMipLevelSize(unsigned int level, RTsize& width, RTsize& height,
                                       RTsize& depth) const {
    checkError(rtBufferGetMipLevelSize3D(m_buffer, level, &width, &height, &depth));
}
inline void BufferObj::setSize(unsigned int dimensionality, const RTsize* dims) {
    checkError(rtBufferSetSizev(m_buffer, dimensionality, dims));
}
inline void BufferObj::getSize(unsigned int dimensionality, RTsize* dims) const {
    checkError(rtBufferGetSizev(m_buffer, dimensionality, dims));
}
inline unsigned int BufferObj::getDimensionality() const {
    unsigned int value = 0;
    checkError(rtBufferGetDimensionality(m_buffer, &value));
    return value;
}
inline void BufferObj::setMipLevelCount(unsigned int levels) {
    checkError(rtBufferSetMipLevelCount(m_buffer, levels));
}
inline unsigned int BufferObj::getMipLevelCount() const {
    unsigned int value = 0;
    checkError(rtBufferGetMipLevelCount(m_buffer, &value));
    return value;
}
inline int BufferObj::getId() const {
    int value = 0;
    checkError(rtBufferGetId(m_buffer, &value));
    return value;
}
inline unsigned int BufferObj::getGLBOId() const {
    unsigned int value = 0;
    checkError(rtBufferGetGLBOId(m_buffer, &value));
    return value;
}
inline void BufferObj::registerGLBuffer() {
    checkError(rtBufferGLRegister(m_buffer));
}
inline void BufferObj::unregisterGLBuffer() {
    checkError(rtBufferGLUnregister(m_buffer));
}
inline void BufferObj::setAttribute(RTbufferattribute attrib, RTsize size, const void* p) {
    checkError(rtBufferSetAttribute(m_buffer, attrib, size, p));
}
inline void BufferObj::getAttribute(RTbufferattribute attrib, RTsize size, void* p) {
    checkError(rtBufferGetAttribute(m_buffer, attrib, size, p));
}
inline void* BufferObj::map(unsigned int level, unsigned int map_flags, void* user_owned) {
    void* mapped = 0;
    checkError(rtBufferMapEx(m_buffer, map_flags, level, user_owned, &mapped));
    return mapped;
}
inline void BufferObj::unmap(unsigned int level) {
    checkError(rtBufferUnmapEx(m_buffer, level));
}
inline void BufferObj::bindProgressiveStream(Buffer source) {
    checkError(rtBufferBindProgressiveStream(m_buffer, internal::api(source)));
}
inline void BufferObj::getProgressiveUpdateReady(int* ready, unsigned int* subframe_count,
                                                 unsigned int* max_subframes) {
    checkError(rtBufferGetProgressiveUpdateReady(m_buffer, ready, subframe_count, max_subframes));
}
inline bool BufferObj::getProgressiveUpdateReady() {
    int ready = 0;
    getProgressiveUpdateReady(&ready, 0, 0);
    return ready != 0;
}
inline bool BufferObj::getProgressiveUpdateReady(unsigned int& subframe_count) {
    int ready = 0;
    getProgressiveUpdateReady(&ready, &subframe_count, 0);
    return ready != 0;
}
inline bool BufferObj::getProgressiveUpdateReady(unsigned int& subframe_count,
                                                 unsigned int& max_subframes) {
    int ready = 0;
    getProgressiveUpdateReady(&ready, &subframe_count, &max_subframes);
    return ready != 0;
}

// ---- TextureSampler ---------------------------------------------------------------------------

inline void TextureSamplerObj::destroy() {
    checkError(rtTextureSamplerDestroy(m_texturesampler));
    m_texturesampler = 0;
}
inline void TextureSamplerObj::validate() {
    checkError(rtTextureSamplerValidate(m_texturesampler));
}
inline Context TextureSamplerObj::getContext() const {
    RTcontext context = 0;
    checkErrorNoGetContext(rtTextureSamplerGetContext(m_texturesampler, &context));
    return Context::take(context);
}
inline RTtexturesampler TextureSamplerObj::get() {
    return m_texturesampler;
}
inline void TextureSamplerObj::setMipLevelCount(unsigned int num_mip_levels) {
    checkError(rtTextureSamplerSetMipLevelCount(m_texturesampler, num_mip_levels));
}
inline unsigned int TextureSamplerObj::getMipLevelCount() const {
    unsigned int value = 0;
    checkError(rtTextureSamplerGetMipLevelCount(m_texturesampler, &value));
    return value;
}
inline void TextureSamplerObj::setArraySize(unsigned int num_textures_in_array) {
    checkError(rtTextureSamplerSetArraySize(m_texturesampler, num_textures_in_array));
}
inline unsigned int TextureSamplerObj::getArraySize() const {
    unsigned int value = 0;
    checkError(rtTextureSamplerGetArraySize(m_texturesampler, &value));
    return value;
}
inline void TextureSamplerObj::setWrapMode(unsigned int dim, RTwrapmode wrapmode) {
    checkError(rtTextureSamplerSetWrapMode(m_texturesampler, dim, wrapmode));
}
inline RTwrapmode TextureSamplerObj::getWrapMode(unsigned int dim) const {
    RTwrapmode value = RTwrapmode();
    checkError(rtTextureSamplerGetWrapMode(m_texturesampler, dim, &value));
    return value;
}
inline void TextureSamplerObj::setFilteringModes(RTfiltermode minification,
                                                 RTfiltermode magnification,
                                                 RTfiltermode mipmapping) {
    checkError(rtTextureSamplerSetFilteringModes(m_texturesampler, minification, magnification,
                                                 mipmapping));
}
inline void TextureSamplerObj::getFilteringModes(RTfiltermode& minification,
                                                 RTfiltermode& magnification,
                                                 RTfiltermode& mipmapping) const {
    checkError(rtTextureSamplerGetFilteringModes(m_texturesampler, &minification, &magnification,
                                                 &mipmapping));
}
inline void TextureSamplerObj::setMaxAnisotropy(float value) {
    checkError(rtTextureSamplerSetMaxAnisotropy(m_texturesampler, value));
}
inline float TextureSamplerObj::getMaxAnisotropy() const {
    float value = 0.0f;
    checkError(rtTextureSamplerGetMaxAnisotropy(m_texturesampler, &value));
    return value;
}
inline void TextureSamplerObj::setMipLevelClamp(float minLevel, float maxLevel) {
    checkError(rtTextureSamplerSetMipLevelClamp(m_texturesampler, minLevel, maxLevel));
}
inline void TextureSamplerObj::getMipLevelClamp(float& minLevel, float& maxLevel) const {
    checkError(rtTextureSamplerGetMipLevelClamp(m_texturesampler, &minLevel, &maxLevel));
}
inline void TextureSamplerObj::setMipLevelBias(float value) {
    checkError(rtTextureSamplerSetMipLevelBias(m_texturesampler, value));
}
inline float TextureSamplerObj::getMipLevelBias() const {
    float value = 0.0f;
    checkError(rtTextureSamplerGetMipLevelBias(m_texturesampler, &value));
    return value;
}
inline void TextureSamplerObj::setReadMode(RTtexturereadmode readmode) {
    checkError(rtTextureSamplerSetReadMode(m_texturesampler, readmode));
}
inline RTtexturereadmode TextureSamplerObj::getReadMode() const {
    RTtexturereadmode value = RTtexturereadmode();
    checkError(rtTextureSamplerGetReadMode(m_texturesampler, &value));
    return value;
}
inline void TextureSamplerObj::setIndexingMode(RTtextureindexmode indexmode) {
    checkError(rtTextureSamplerSetIndexingMode(m_texturesampler, indexmode));
}
inline RTtextureindexmode TextureSamplerObj::getIndexingMode() const {
    RTtextureindexmode value = RTtextureindexmode();
    checkError(rtTextureSamplerGetIndexingMode(m_texturesampler, &value));
    return value;
}
inline int TextureSamplerObj::getId() const {
    int value = 0;
    checkError(rtTextureSamplerGetId(m_texturesampler, &value));
    return value;
}
inline void TextureSamplerObj::setBuffer(unsigned int texture_array_idx, unsigned int mip_level,
                                         Buffer buffer) {
    checkError(rtTextureSamplerSetBuffer(m_texturesampler, texture_array_idx, mip_level,
                                         internal::api(buffer)));
}
inline Buffer TextureSamplerObj::getBuffer(unsigned int texture_array_idx,
                                           unsigned int mip_level) const {
    RTbuffer value = 0;
    checkError(rtTextureSamplerGetBuffer(m_texturesampler, texture_array_idx, mip_level, &value));
    return Buffer::take(value);
}
inline void TextureSamplerObj::setBuffer(Buffer buffer) {
    setBuffer(0, 0, buffer);
}
inline Buffer TextureSamplerObj::getBuffer() const {
    return getBuffer(0, 0);
}
inline void TextureSamplerObj::registerGLTexture() {
    checkError(rtTextureSamplerGLRegister(m_texturesampler));
}
inline void TextureSamplerObj::unregisterGLTexture() {
    checkError(rtTextureSamplerGLUnregister(m_texturesampler));
}

// ---- PostprocessingStage ----------------------------------------------------------------------

inline void PostprocessingStageObj::destroy() {
    checkError(rtPostProcessingStageDestroy(m_stage));
    m_stage = 0;
}
// The C API has no function for it.
inline void PostprocessingStageObj::validate() {
    getContext();
}
inline Context PostprocessingStageObj::getContext() const {
    RTcontext context = 0;
    checkErrorNoGetContext(rtPostProcessingStageGetContext(m_stage, &context));
    return Context::take(context);
}
inline RTpostprocessingstage PostprocessingStageObj::get() {
    return m_stage;
}
inline Variable PostprocessingStageObj::declareVariable(const std::string& name) {
    RTvariable value = 0;
    checkError(rtPostProcessingStageDeclareVariable(m_stage, name.c_str(), &value));
    return Variable::take(value);
}
inline Variable PostprocessingStageObj::queryVariable(const std::string& name) const {
    RTvariable value = 0;
    checkError(rtPostProcessingStageQueryVariable(m_stage, name.c_str(), &value));
    return Variable::take(value);
}
inline unsigned int PostprocessingStageObj::getVariableCount() const {
    unsigned int value = 0;
    checkError(rtPostProcessingStageGetVariableCount(m_stage, &value));
    return value;
}
inline Variable PostprocessingStageObj::getVariable(unsigned int index) const {
    RTvariable value = 0;
    checkError(rtPostProcessingStageGetVariable(m_stage, index, &value));
    return Variable::take(value);
}

// ---- CommandList ------------------------------------------------------------------------------

inline void CommandListObj::destroy() {
    checkError(rtCommandListDestroy(m_list));
    m_list = 0;
}
// The C API has no function for it.
inline void CommandListObj::validate() {
    getContext();
}
inline Context CommandListObj::getContext() const {
    RTcontext context = 0;
    checkErrorNoGetContext(rtCommandListGetContext(m_list, &context));
    return Context::take(context);
}
inline RTcommandlist CommandListObj::get() {
    return m_list;
}
inline void CommandListObj::appendPostprocessingStage(PostprocessingStage stage,
                                                      RTsize launch_width, RTsize launch_height) {
    checkError(rtCommandListAppendPostprocessingStage(m_list, internal::api(stage), launch_width,
                                                      launch_height));
}
inline void CommandListObj::appendLaunch(unsigned int entryIndex, RTsize launch_width,
                                         RTsize launch_height) {
    checkError(rtCommandListAppendLaunch2D(m_list, entryIndex, launch_width, launch_height));
}
inline void CommandListObj::finalize() {
    checkError(rtCommandListFinalize(m_list));
}
inline void CommandListObj::execute() {
    checkError(rtCommandListExecute(m_list));
}

// ---- RemoteDevice -----------------------------------------------------------------------------

inline RemoteDevice RemoteDeviceObj::create(const std::string& url, const std::string& username,
                                            const std::string& password) {
    RTremotedevice device = 0;
    internal::check(rtRemoteDeviceCreate(url.c_str(), username.c_str(), password.c_str(), &device));
    return RemoteDevice::take(device);
}
inline void RemoteDeviceObj::destroy() {
    internal::check(rtRemoteDeviceDestroy(m_device));
    m_device = 0;
}
inline Context RemoteDeviceObj::getContext() const {
    return Context();
}
inline RTremotedevice RemoteDeviceObj::get() {
    return m_device;
}
inline void RemoteDeviceObj::reserve(unsigned int num_nodes, unsigned int config_idx) {
    internal::check(rtRemoteDeviceReserve(m_device, num_nodes, config_idx));
}
inline void RemoteDeviceObj::release() {
    internal::check(rtRemoteDeviceRelease(m_device));
}
inline void RemoteDeviceObj::getAttribute(RTremotedeviceattribute attrib, RTsize size, void* p) {
    internal::check(rtRemoteDeviceGetAttribute(m_device, attrib, size, p));
}

} // namespace optix

#endif
