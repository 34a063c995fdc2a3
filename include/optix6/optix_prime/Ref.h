/* SPDX-License-Identifier: Apache-2.0 */
// Base of the objects that Prime++'s handles count.
#ifndef OPTIX_PRIMEPP_REF_H
#define OPTIX_PRIMEPP_REF_H

#include "Atom.h"

namespace optix {
namespace prime {

// Any thread may count. The object is deleted with its last reference.
class RefCountedObj {
public:
    void ref() { ++count_; }
    void unref() {
        if (--count_ == 0)
            delete this;
    }

protected:
    RefCountedObj() {}
    virtual ~RefCountedObj() {}

private:
    RefCountedObj(const RefCountedObj&);
    RefCountedObj& operator=(const RefCountedObj&);
    Atom32 count_;
};

} // namespace prime
} // namespace optix

#endif
