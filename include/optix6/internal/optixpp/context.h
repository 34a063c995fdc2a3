// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API: contexts and programs. A member function calls the C function
// whose name has the same words. Source: OptiX API reference 6.0, chapter 7.
#ifndef SUNSTONE_OPTIXPP_CONTEXT_H
#define SUNSTONE_OPTIXPP_CONTEXT_H

#include "handle.h"

namespace optix {

/** A context: creates every other object, holds the programs of entry points and ray types, and
   launches. destroy() destroys all its objects. */
class ContextObj : public ScopedObj {
public:
    typedef RTcontext api_t;

    void destroy() override;
    void validate() override;
    Context getContext() const override;
    RTcontext get();

    /** Devices of the machine; the ordinals are those of this API. */
    static unsigned int getDeviceCount();
    static std::string getDeviceName(int ordinal);
    static std::string getDevicePCIBusId(int ordinal);
    static void getDeviceAttribute(int ordinal, RTdeviceattribute attrib, RTsize size, void* p);
    /** The devices that may share a context with this one, including itself. */
    static std::vector<int> getCompatibleDevices(int ordinal);
    static Context create();

    void checkError(RTresult code) const override;
    using APIObj::checkError;
    std::string getErrorString(RTresult code) const;
    /** Without effect. */
    void compile();
    int getRunningState() const;

    /** The second argument has no effect. */
    Acceleration createAcceleration(const std::string& builder, const std::string& ignored = "");

    /** Buffers with format and size; type is a RTbuffertype with RTbufferflag bits. */
    Buffer createBuffer(unsigned int type);
    Buffer createBuffer(unsigned int type, RTformat format);
    Buffer createBuffer(unsigned int type, RTformat format, RTsize width);
    Buffer createBuffer(unsigned int type, RTformat format, RTsize width, RTsize height);
    Buffer createBuffer(unsigned int type, RTformat format, RTsize width, RTsize height,
                        RTsize depth);
    Buffer createMipmappedBuffer(unsigned int type, RTformat format, RTsize width,
                                 unsigned int levels);
    Buffer createMipmappedBuffer(unsigned int type, RTformat format, RTsize width, RTsize height,
                                 unsigned int levels);
    Buffer createMipmappedBuffer(unsigned int type, RTformat format, RTsize width, RTsize height,
                                 RTsize depth, unsigned int levels);
    /** Layers are the depth of a buffer: six for a cube, a multiple of six for a layered cube. */
    Buffer create1DLayeredBuffer(unsigned int type, RTformat format, RTsize width, RTsize layers,
                                 unsigned int levels);
    Buffer create2DLayeredBuffer(unsigned int type, RTformat format, RTsize width, RTsize height,
                                 RTsize layers, unsigned int levels);
    Buffer createCubeBuffer(unsigned int type, RTformat format, RTsize width, RTsize height,
                            unsigned int levels);
    Buffer createCubeLayeredBuffer(unsigned int type, RTformat format, RTsize width, RTsize height,
                                   RTsize faces, unsigned int levels);
    Buffer createBufferForCUDA(unsigned int type);
    Buffer createBufferForCUDA(unsigned int type, RTformat format);
    Buffer createBufferForCUDA(unsigned int type, RTformat format, RTsize width);
    Buffer createBufferForCUDA(unsigned int type, RTformat format, RTsize width, RTsize height);
    Buffer createBufferForCUDA(unsigned int type, RTformat format, RTsize width, RTsize height,
                               RTsize depth);
    Buffer createBufferFromGLBO(unsigned int type, unsigned int vbo);
    TextureSampler createTextureSamplerFromGLImage(unsigned int id, RTgltarget target);

    Buffer getBufferFromId(int buffer_id);
    Program getProgramFromId(int program_id);
    TextureSampler getTextureSamplerFromId(int sampler_id);

    Geometry createGeometry();
    GeometryTriangles createGeometryTriangles();
    GeometryInstance createGeometryInstance();
    /** These overloads also set the geometry and all materials, or the children. */
    template <class Iterator>
    GeometryInstance createGeometryInstance(Geometry geometry, Iterator matlbegin,
                                            Iterator matlend);
    GeometryInstance createGeometryInstance(GeometryTriangles geometry, Material mat);
    Group createGroup();
    template <class Iterator>
    Group createGroup(Iterator childbegin, Iterator childend);
    GeometryGroup createGeometryGroup();
    template <class Iterator>
    GeometryGroup createGeometryGroup(Iterator childbegin, Iterator childend);
    Transform createTransform();
    Material createMaterial();
    Program createProgramFromPTXFile(const std::string& filename, const std::string& program_name);
    Program createProgramFromPTXFiles(const std::vector<std::string>& filenames,
                                      const std::string& program_name);
    Program createProgramFromPTXFiles(const std::vector<const char*>& filenames,
                                      const std::string& program_name);
    Program createProgramFromPTXString(const std::string& ptx, const std::string& program_name);
    Program createProgramFromPTXStrings(const std::vector<std::string>& ptxStrings,
                                        const std::string& program_name);
    Program createProgramFromPTXStrings(const std::vector<const char*>& ptxStrings,
                                        const std::string& program_name);
    Selector createSelector();
    TextureSampler createTextureSampler();
    PostprocessingStage createBuiltinPostProcessingStage(const std::string& builtin_name);
    CommandList createCommandList();

    /** The devices that the context uses. */
    template <class Iterator>
    void setDevices(Iterator begin, Iterator end);
    std::vector<int> getEnabledDevices() const;
    unsigned int getEnabledDeviceCount() const;

    int getMaxTextureCount() const;
    int getCPUNumThreads() const;
    RTsize getUsedHostMemory() const;
    bool getPreferFastRecompiles() const;
    bool getForceInlineUserFunctions() const;
    int getGPUPagingActive() const;
    int getGPUPagingForcedOff() const;
    RTsize getAvailableDeviceMemory(int ordinal) const;
    void setCPUNumThreads(int cpu_num_threads);
    void setPreferFastRecompiles(bool enabled);
    void setForceInlineUserFunctions(bool enabled);
    void setDiskCacheLocation(const std::string& path);
    std::string getDiskCacheLocation();
    void setDiskCacheMemoryLimits(RTsize lowWaterMark, RTsize highWaterMark);
    void getDiskCacheMemoryLimits(RTsize& lowWaterMark, RTsize& highWaterMark);
    void setGPUPagingForcedOff(int gpu_paging_forced_off);
    template <class T>
    void setAttribute(RTcontextattribute attribute, const T& val);

    void setStackSize(RTsize stack_size_bytes);
    RTsize getStackSize() const;
    void setMaxCallableProgramDepth(unsigned int max_depth);
    unsigned int getMaxCallableProgramDepth() const;
    void setMaxTraceDepth(unsigned int max_depth);
    unsigned int getMaxTraceDepth() const;
    /** Without effect. */
    void setTimeoutCallback(RTtimeoutcallback callback, double min_polling_seconds);
    void setUsageReportCallback(RTusagereportcallback callback, int verbosity, void* cbdata);

    void setEntryPointCount(unsigned int num_entry_points);
    unsigned int getEntryPointCount() const;
    void setRayTypeCount(unsigned int num_ray_types);
    unsigned int getRayTypeCount() const;
    void setRayGenerationProgram(unsigned int entry_point_index, Program program);
    Program getRayGenerationProgram(unsigned int entry_point_index) const;
    void setExceptionProgram(unsigned int entry_point_index, Program program);
    Program getExceptionProgram(unsigned int entry_point_index) const;
    void setExceptionEnabled(RTexception exception, bool enabled);
    bool getExceptionEnabled(RTexception exception) const;
    void setMissProgram(unsigned int ray_type_index, Program program);
    Program getMissProgram(unsigned int ray_type_index) const;

    void launch(unsigned int entry_point_index, RTsize image_width);
    void launch(unsigned int entry_point_index, RTsize image_width, RTsize image_height);
    void launch(unsigned int entry_point_index, RTsize image_width, RTsize image_height,
                RTsize image_depth);
    void launchProgressive(unsigned int entry_point_index, RTsize image_width, RTsize image_height,
                           unsigned int max_subframes);
    void stopProgressive();
    /** The nodes that take part in progressive launches; a null handle: all. */
    void setRemoteDevice(RemoteDevice remote_dev);

    void setPrintEnabled(bool enabled);
    bool getPrintEnabled() const;
    void setPrintBufferSize(RTsize buffer_size_bytes);
    RTsize getPrintBufferSize() const;
    void setPrintLaunchIndex(int x, int y = -1, int z = -1);
    optix::int3 getPrintLaunchIndex() const;

    Variable declareVariable(const std::string& name) override;
    Variable queryVariable(const std::string& name) const override;
    void removeVariable(Variable v) override;
    unsigned int getVariableCount() const override;
    Variable getVariable(unsigned int index) const override;

private:
    friend class Handle<ContextObj>;
    explicit ContextObj(RTcontext object) : m_context(object) {}

    template <typename T>
    T attributeOf(RTcontextattribute attribute) const;

    RTcontext m_context;
};

/** A program of device code. */
class ProgramObj : public ScopedObj {
public:
    typedef RTprogram api_t;

    void destroy() override;
    void validate() override;
    Context getContext() const override;
    RTprogram get();

    Variable declareVariable(const std::string& name) override;
    Variable queryVariable(const std::string& name) const override;
    void removeVariable(Variable v) override;
    unsigned int getVariableCount() const override;
    Variable getVariable(unsigned int index) const override;

    /** The programs that a marked call may reach, by their ids. */
    void setCallsitePotentialCallees(const std::string& callSiteName,
                                     const std::vector<int>& calleeIds);
    int getId() const;

private:
    friend class Handle<ProgramObj>;
    explicit ProgramObj(RTprogram object) : m_program(object) {}

    RTprogram m_program;
};

} // namespace optix

#endif
