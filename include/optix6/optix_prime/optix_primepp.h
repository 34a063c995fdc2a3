/* SPDX-License-Identifier: Apache-2.0 */
// Prime++: classes over the C API of OptiX Prime. Handles share objects; an object's C handle is
// destroyed with its last handle. Models, queries and buffer descriptors keep their context alive,
// queries keep their model alive. Failing calls throw Exception.
#ifndef OPTIX_PRIMEPP_H
#define OPTIX_PRIMEPP_H

#include "Handle.h"
#include "optix_prime.h"

#include <exception>
#include <string>
#include <vector>

#ifdef CHK
#undef CHK
#endif
// Within the classes: throws with the last error message of the object's context.
#define CHK(code) checkError(code, getContext()->getRTPcontext())

namespace optix {
namespace prime {

class BufferDescObj;
class ContextObj;
class ModelObj;
class QueryObj;

typedef Handle<BufferDescObj> BufferDesc;
typedef Handle<ContextObj> Context;
typedef Handle<ModelObj> Model;
typedef Handle<QueryObj> Query;

class Exception : public std::exception {
public:
    virtual ~Exception() throw() {}
    RTPresult getErrorCode() const { return code_; }
    const std::string& getErrorString() const { return text_; }
    virtual const char* what() const throw() { return text_.c_str(); }

    // With the text of the code, or the last error message of the context.
    static Exception makeException(RTPresult code) {
        const char* text = 0;
        rtpGetErrorString(code, &text);
        return Exception(code, text ? text : "");
    }
    static Exception makeException(RTPresult code, RTPcontext context) {
        const char* text = 0;
        if (rtpContextGetLastErrorString(context, &text) != RTP_SUCCESS || !text)
            return makeException(code);
        return Exception(code, text);
    }

private:
    Exception(RTPresult code, const std::string& text) : code_(code), text_(text) {}
    RTPresult code_;
    std::string text_;
};

inline void checkError(RTPresult code) {
    if (code != RTP_SUCCESS)
        throw Exception::makeException(code);
}
inline void checkError(RTPresult code, RTPcontext context) {
    if (code != RTP_SUCCESS)
        throw Exception::makeException(code, context);
}

inline std::string getVersionString() {
    const char* text = 0;
    checkError(rtpGetVersionString(&text));
    return text;
}

class ContextObj : public RefCountedObj {
public:
    static Context create(RTPcontexttype type) {
        RTPcontext context = 0;
        checkError(rtpContextCreate(type, &context));
        return Context(new ContextObj(context));
    }

    inline BufferDesc createBufferDesc(RTPbufferformat format, RTPbuffertype type, void* buffer);
    inline Model createModel();

    void setCudaDeviceNumbers(const std::vector<unsigned>& deviceNumbers) {
        setCudaDeviceNumbers(unsigned(deviceNumbers.size()),
                             deviceNumbers.empty() ? 0 : &deviceNumbers[0]);
    }
    void setCudaDeviceNumbers(unsigned deviceCount, const unsigned* deviceNumbers) {
        CHK(rtpContextSetCudaDeviceNumbers(context_, deviceCount, deviceNumbers));
    }
    void setCpuThreads(unsigned numThreads) { CHK(rtpContextSetCpuThreads(context_, numThreads)); }

    std::string getLastErrorMessage() {
        const char* text = 0;
        checkError(rtpContextGetLastErrorString(context_, &text));
        return text;
    }
    RTPcontext getRTPcontext() { return context_; }

private:
    explicit ContextObj(RTPcontext context) : context_(context) {}
    ~ContextObj() { rtpContextDestroy(context_); }
    ContextObj* getContext() { return this; }
    RTPcontext context_;
};

class BufferDescObj : public RefCountedObj {
public:
    Context getContext() { return context_; }
    void setRange(RTPsize begin, RTPsize end) { CHK(rtpBufferDescSetRange(desc_, begin, end)); }
    void setStride(unsigned strideBytes) { CHK(rtpBufferDescSetStride(desc_, strideBytes)); }
    void setCudaDeviceNumber(unsigned deviceNumber) {
        CHK(rtpBufferDescSetCudaDeviceNumber(desc_, deviceNumber));
    }
    RTPbufferdesc getRTPbufferdesc() { return desc_; }

private:
    friend class ContextObj;
    BufferDescObj(const Context& context, RTPbufferdesc desc) : context_(context), desc_(desc) {}
    ~BufferDescObj() { rtpBufferDescDestroy(desc_); }
    Context context_;
    RTPbufferdesc desc_;
};

class ModelObj : public RefCountedObj {
public:
    inline Query createQuery(RTPquerytype queryType);
    Context getContext() { return context_; }
    void finish() { CHK(rtpModelFinish(model_)); }
    int isFinished() {
        int finished = 0;
        CHK(rtpModelGetFinished(model_, &finished));
        return finished;
    }
    void update(unsigned hints) { CHK(rtpModelUpdate(model_, hints)); }
    void copy(const Model& srcModel) { CHK(rtpModelCopy(model_, srcModel->getRTPmodel())); }

    // Every three vertices are a triangle.
    void setTriangles(RTPsize triCount, RTPbuffertype type, const void* vertPtr,
                      unsigned stride = 0) {
        setTriangles(vertexDesc(type, vertPtr, 3 * triCount, stride));
    }
    void setTriangles(RTPsize triCount, RTPbuffertype type, const void* indexPtr, RTPsize vertCount,
                      RTPbuffertype vertType, const void* vertPtr, unsigned stride = 0) {
        BufferDesc indices = context_->createBufferDesc(RTP_BUFFER_FORMAT_INDICES_INT3, type,
                                                        const_cast<void*>(indexPtr));
        indices->setRange(0, triCount);
        setTriangles(indices, vertexDesc(vertType, vertPtr, vertCount, stride));
    }
    void setTriangles(const BufferDesc& vertices) {
        CHK(rtpModelSetTriangles(model_, 0, vertices->getRTPbufferdesc()));
    }
    void setTriangles(const BufferDesc& indices, const BufferDesc& vertices) {
        CHK(rtpModelSetTriangles(model_, indices->getRTPbufferdesc(),
                                 vertices->getRTPbufferdesc()));
    }

    void setInstances(RTPsize count, RTPbuffertype instanceType, const RTPmodel* instanceList,
                      RTPbufferformat transformFormat, RTPbuffertype transformType,
                      const void* transformList) {
        BufferDesc instances = context_->createBufferDesc(
            RTP_BUFFER_FORMAT_INSTANCE_MODEL, instanceType, const_cast<RTPmodel*>(instanceList));
        instances->setRange(0, count);
        BufferDesc transforms = context_->createBufferDesc(transformFormat, transformType,
                                                           const_cast<void*>(transformList));
        transforms->setRange(0, count);
        setInstances(instances, transforms);
    }
    void setInstances(const BufferDesc& instances, const BufferDesc& transforms) {
        CHK(rtpModelSetInstances(model_, instances->getRTPbufferdesc(),
                                 transforms->getRTPbufferdesc()));
    }

    void setBuilderParameter(RTPbuilderparam param, RTPsize size, const void* p) {
        CHK(rtpModelSetBuilderParameter(model_, param, size, p));
    }
    template <typename T>
    void setBuilderParameter(RTPbuilderparam param, const T& val) {
        setBuilderParameter(param, sizeof(T), &val);
    }
    RTPmodel getRTPmodel() { return model_; }

private:
    friend class ContextObj;
    ModelObj(const Context& context, RTPmodel model) : context_(context), model_(model) {}
    ~ModelObj() { rtpModelDestroy(model_); }
    BufferDesc vertexDesc(RTPbuffertype type, const void* vertices, RTPsize count,
                          unsigned stride) {
        BufferDesc desc = context_->createBufferDesc(RTP_BUFFER_FORMAT_VERTEX_FLOAT3, type,
                                                     const_cast<void*>(vertices));
        desc->setRange(0, count);
        desc->setStride(stride);
        return desc;
    }
    Context context_;
    RTPmodel model_;
};

class QueryObj : public RefCountedObj {
public:
    Context getContext() { return model_->getContext(); }
    void finish() { CHK(rtpQueryFinish(query_)); }
    int isFinished() {
        int finished = 0;
        CHK(rtpQueryGetFinished(query_, &finished));
        return finished;
    }
    void setCudaStream(cudaStream_t stream) { CHK(rtpQuerySetCudaStream(query_, stream)); }
    void setRays(RTPsize count, RTPbufferformat format, RTPbuffertype type, void* rays) {
        setRays(desc(count, format, type, rays));
    }
    void setRays(const BufferDesc& rays) { CHK(rtpQuerySetRays(query_, rays->getRTPbufferdesc())); }
    void setHits(RTPsize count, RTPbufferformat format, RTPbuffertype type, void* hits) {
        setHits(desc(count, format, type, hits));
    }
    void setHits(const BufferDesc& hits) { CHK(rtpQuerySetHits(query_, hits->getRTPbufferdesc())); }
    void execute(unsigned hint) { CHK(rtpQueryExecute(query_, hint)); }
    RTPquery getRTPquery() { return query_; }

private:
    friend class ModelObj;
    QueryObj(const Model& model, RTPquery query) : model_(model), query_(query) {}
    ~QueryObj() { rtpQueryDestroy(query_); }
    BufferDesc desc(RTPsize count, RTPbufferformat format, RTPbuffertype type, void* buffer) {
        BufferDesc made = getContext()->createBufferDesc(format, type, buffer);
        made->setRange(0, count);
        return made;
    }
    Model model_;
    RTPquery query_;
};

inline BufferDesc ContextObj::createBufferDesc(RTPbufferformat format, RTPbuffertype type,
                                               void* buffer) {
    RTPbufferdesc desc = 0;
    CHK(rtpBufferDescCreate(context_, format, type, buffer, &desc));
    return BufferDesc(new BufferDescObj(Context(this), desc));
}

inline Model ContextObj::createModel() {
    RTPmodel model = 0;
    CHK(rtpModelCreate(context_, &model));
    return Model(new ModelObj(Context(this), model));
}

inline Query ModelObj::createQuery(RTPquerytype queryType) {
    RTPquery query = 0;
    CHK(rtpQueryCreate(model_, queryType, &query));
    return Query(new QueryObj(Model(this), query));
}

} // namespace prime
} // namespace optix

#endif
