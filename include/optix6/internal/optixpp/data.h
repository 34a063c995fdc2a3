// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API: buffers, textures, post-processing stages and command lists.
// A member function calls the C function whose name has the same words. Source: OptiX API reference
// 6.0, chapter 7.
#ifndef SUNSTONE_OPTIXPP_DATA_H
#define SUNSTONE_OPTIXPP_DATA_H

#include "handle.h"

namespace optix {

/** A buffer of one to three dimensions. */
class BufferObj : public DestroyableObj {
public:
    typedef RTbuffer api_t;

    void destroy() override;
    void validate() override;
    Context getContext() const override;
    RTbuffer get();

    void setFormat(RTformat format);
    RTformat getFormat() const;
    void setElementSize(RTsize size_of_element);
    RTsize getElementSize() const;
    void getDevicePointer(int optix_device_ordinal, void** device_pointer);
    void* getDevicePointer(int optix_device_ordinal);
    void setDevicePointer(int optix_device_ordinal, void* device_pointer);
    void markDirty();

    void setSize(RTsize width);
    void getSize(RTsize& width) const;
    void getMipLevelSize(unsigned int level, RTsize& width) const;
    void setSize(RTsize width, RTsize height);
    void getSize(RTsize& width, RTsize& height) const;
    void getMipLevelSize(unsigned int level, RTsize& width, RTsize& height) const;
    void setSize(RTsize width, RTsize height, RTsize depth);
    void getSize(RTsize& width, RTsize& height, RTsize& depth) const;
    void getMipLevelSize(unsigned int level, RTsize& width, RTsize& height, RTsize& depth) const;
    void setSize(unsigned int dimensionality, const RTsize* dims);
    void getSize(unsigned int dimensionality, RTsize* dims) const;
    unsigned int getDimensionality() const;
    void setMipLevelCount(unsigned int levels);
    unsigned int getMipLevelCount() const;

    /** The id for bufferId on the device. */
    int getId() const;

    unsigned int getGLBOId() const;
    void registerGLBuffer();
    void unregisterGLBuffer();

    void setAttribute(RTbufferattribute attrib, RTsize size, const void* p);
    void getAttribute(RTbufferattribute attrib, RTsize size, void* p);

    void* map(unsigned int level = 0, unsigned int map_flags = RT_BUFFER_MAP_READ_WRITE,
              void* user_owned = 0);
    void unmap(unsigned int level = 0);

    void bindProgressiveStream(Buffer source);
    void getProgressiveUpdateReady(int* ready, unsigned int* subframe_count,
                                   unsigned int* max_subframes);
    bool getProgressiveUpdateReady();
    bool getProgressiveUpdateReady(unsigned int& subframe_count);
    bool getProgressiveUpdateReady(unsigned int& subframe_count, unsigned int& max_subframes);

private:
    friend class Handle<BufferObj>;
    explicit BufferObj(RTbuffer object) : m_buffer(object) {}

    RTbuffer m_buffer;
};

/** How a texture is read, with its buffer. */
class TextureSamplerObj : public DestroyableObj {
public:
    typedef RTtexturesampler api_t;

    void destroy() override;
    void validate() override;
    Context getContext() const override;
    RTtexturesampler get();

    /** Deprecated: levels are those of the buffer, arrays have one texture. */
    void setMipLevelCount(unsigned int num_mip_levels);
    unsigned int getMipLevelCount() const;
    void setArraySize(unsigned int num_textures_in_array);
    unsigned int getArraySize() const;

    void setWrapMode(unsigned int dim, RTwrapmode wrapmode);
    RTwrapmode getWrapMode(unsigned int dim) const;
    void setFilteringModes(RTfiltermode minification, RTfiltermode magnification,
                           RTfiltermode mipmapping);
    void getFilteringModes(RTfiltermode& minification, RTfiltermode& magnification,
                           RTfiltermode& mipmapping) const;
    void setMaxAnisotropy(float value);
    float getMaxAnisotropy() const;
    void setMipLevelClamp(float minLevel, float maxLevel);
    void getMipLevelClamp(float& minLevel, float& maxLevel) const;
    void setMipLevelBias(float value);
    float getMipLevelBias() const;
    void setReadMode(RTtexturereadmode readmode);
    RTtexturereadmode getReadMode() const;
    void setIndexingMode(RTtextureindexmode indexmode);
    RTtextureindexmode getIndexingMode() const;

    /** The id for texture functions on the device. */
    int getId() const;

    /** With array index and level: deprecated, both 0. */
    void setBuffer(unsigned int texture_array_idx, unsigned int mip_level, Buffer buffer);
    Buffer getBuffer(unsigned int texture_array_idx, unsigned int mip_level) const;
    void setBuffer(Buffer buffer);
    Buffer getBuffer() const;

    void registerGLTexture();
    void unregisterGLTexture();

private:
    friend class Handle<TextureSamplerObj>;
    explicit TextureSamplerObj(RTtexturesampler object) : m_texturesampler(object) {}

    RTtexturesampler m_texturesampler;
};

/** A built-in operation on finished images, such as the denoiser. */
class PostprocessingStageObj : public DestroyableObj {
public:
    typedef RTpostprocessingstage api_t;

    void destroy() override;
    void validate() override;
    Context getContext() const override;
    RTpostprocessingstage get();

    Variable declareVariable(const std::string& name);
    Variable queryVariable(const std::string& name) const;
    unsigned int getVariableCount() const;
    Variable getVariable(unsigned int index) const;

private:
    friend class Handle<PostprocessingStageObj>;
    explicit PostprocessingStageObj(RTpostprocessingstage object) : m_stage(object) {}

    RTpostprocessingstage m_stage;
};

/** Launches and stages to run in order. */
class CommandListObj : public DestroyableObj {
public:
    typedef RTcommandlist api_t;

    void destroy() override;
    void validate() override;
    Context getContext() const override;
    RTcommandlist get();

    void appendPostprocessingStage(PostprocessingStage stage, RTsize launch_width,
                                   RTsize launch_height);
    void appendLaunch(unsigned int entryIndex, RTsize launch_width, RTsize launch_height);
    /** Ends the list; execute needs it. */
    void finalize();
    void execute();

private:
    friend class Handle<CommandListObj>;
    explicit CommandListObj(RTcommandlist object) : m_list(object) {}

    RTcommandlist m_list;
};

/** Ranks that take part in progressive launches. It belongs to no context. */
class RemoteDeviceObj : public APIObj {
public:
    typedef RTremotedevice api_t;

    static RemoteDevice create(const std::string& url, const std::string& username,
                               const std::string& password);
    void destroy();
    /** A null handle. */
    Context getContext() const override;
    RTremotedevice get();

    void reserve(unsigned int num_nodes, unsigned int config_idx);
    void release();
    void getAttribute(RTremotedeviceattribute attrib, RTsize size, void* p);

private:
    friend class Handle<RemoteDeviceObj>;
    explicit RemoteDeviceObj(RTremotedevice object) : m_device(object) {}

    RTremotedevice m_device;
};

} // namespace optix

#endif
