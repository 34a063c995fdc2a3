// SPDX-License-Identifier: Apache-2.0
// The functions of one ABI's table: Adapter<kAbi, function>::call has the C signature of the slot,
// brings arguments that differ between ABIs into our form and calls the function. Which arguments
// those are follows from their types (client_structs.h); all others go through as they are.
#pragma once

#include "api/optix7/client_structs.h"

namespace sunstone::optix7 {

// One argument: Client is what the slot's signature has.
template <Abi kAbi, class Ours>
class Argument {
public:
    using Client = Ours;
    explicit Argument(Client given) : given_(given) {}
    Ours get() { return given_; }
    void finish(OptixResult) {}

private:
    Client given_;
};

template <Abi kAbi, DiffersBetweenAbis T>
class Argument<kAbi, const T*> {
public:
    using Client = const T*;
    explicit Argument(Client given) : isNull_(!given) {
        if (given)
            ours_ = fromClient<T>(given, kAbi);
    }
    const T* get() { return isNull_ ? nullptr : &ours_; }
    void finish(OptixResult) {}

private:
    bool isNull_;
    T ours_;
};

// What a function returns through a pointer: only the client's bytes are written, on success.
template <Abi kAbi, DiffersBetweenAbis T>
class Argument<kAbi, T*> {
public:
    using Client = T*;
    explicit Argument(Client given) : given_(given) {
        std::memset(static_cast<void*>(&ours_), 0, sizeof(T)); // its padding too
    }
    T* get() { return given_ ? &ours_ : nullptr; }
    void finish(OptixResult result) {
        if (given_ && result == OPTIX_SUCCESS)
            std::memcpy(static_cast<void*>(given_), &ours_, clientBytes<T>(kAbi));
    }

private:
    T* given_;
    T ours_;
};

template <Abi kAbi>
class Argument<kAbi, BuildInputs> {
public:
    using Client = const OptixBuildInput*;
    explicit Argument(Client given) : given_(given) {}
    BuildInputs get() { return BuildInputs(given_, kAbi); }
    void finish(OptixResult) {}

private:
    Client given_;
};

template <Abi kAbi, auto kFunction>
struct Adapter;
template <Abi kAbi, class... Ours, OptixResult (*kFunction)(Ours...)>
struct Adapter<kAbi, kFunction> {
    static OptixResult call(typename Argument<kAbi, Ours>::Client... given) {
        return forward(Argument<kAbi, Ours>(given)...);
    }

private:
    static OptixResult forward(Argument<kAbi, Ours>... arguments) {
        const OptixResult result = kFunction(arguments.get()...);
        (arguments.finish(result), ...);
        return result;
    }
};
// A function that wants to know the ABI takes it first.
template <Abi kAbi, class... Ours, OptixResult (*kFunction)(Abi, Ours...)>
struct Adapter<kAbi, kFunction> {
    static OptixResult call(typename Argument<kAbi, Ours>::Client... given) {
        return forward(Argument<kAbi, Ours>(given)...);
    }

private:
    static OptixResult forward(Argument<kAbi, Ours>... arguments) {
        const OptixResult result = kFunction(kAbi, arguments.get()...);
        (arguments.finish(result), ...);
        return result;
    }
};

} // namespace sunstone::optix7
