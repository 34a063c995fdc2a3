// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API, for the host: reference-counted handles, exceptions, and a
// class for each kind of object. The classes are in ../internal/optixpp; the files *_calls.h there
// define their member functions. Source: OptiX API reference 6.0, sections 5.27, 8.27.
#ifndef SUNSTONE_OPTIXU_OPTIXPP_NAMESPACE_H
#define SUNSTONE_OPTIXU_OPTIXPP_NAMESPACE_H

#include "../internal/optixpp/context_calls.h"
#include "../internal/optixpp/data_calls.h"
#include "../internal/optixpp/geometry_calls.h"
#include "../internal/optixpp/nodes_calls.h"
#include "../internal/optixpp/variable_calls.h"

// Ids in structures that host and device share. Device code has classes of the same layout in
// optix_device.h.
#ifndef __CUDACC__
#define rtBufferId optix::bufferId
#define rtCallableProgramId optix::callableProgramId
#define rtMarkedCallableProgramId optix::markedCallableProgramId

namespace optix {

/** Result of BufferObj::getId. */
template <typename T, int Dim = 1>
struct bufferId {
    bufferId() {}
    bufferId(int id) : m_id(id) {}
    int getId() const { return m_id; }

private:
    int m_id;
};

template <typename T>
class callableProgramId;

/** Result of ProgramObj::getId for a program with this signature. */
template <typename ReturnT, typename... ArgTs>
class callableProgramId<ReturnT(ArgTs...)> {
    static_assert(sizeof...(ArgTs) <= 10, "callable programs have at most ten parameters");

public:
    callableProgramId() {}
    callableProgramId(int id) : m_id(id) {}
    int getId() const { return m_id; }

private:
    int m_id;
};

/** On the device an id with a call site; on the host it lets shared files compile. */
template <typename T>
class markedCallableProgramId {
public:
    markedCallableProgramId() {}
    markedCallableProgramId(int) {}
};

} // namespace optix
#endif

#endif
