// SPDX-License-Identifier: Apache-2.0
// All builder kernels, compiled to PTX when the library is built; builder.cpp launches them.
#include "bvh/gpu/build/arrange.h"
#include "bvh/gpu/build/collapse.h"
#include "bvh/gpu/build/finish.h"
#include "bvh/gpu/build/hierarchy.h"
#include "bvh/gpu/build/micromaps.h"
#include "bvh/gpu/build/presplit.h"
#include "bvh/gpu/build/references.h"
#include "bvh/gpu/build/refit.h"
#include "bvh/gpu/build/relocate.h"
#include "bvh/gpu/build/small.h"
#include "bvh/gpu/build/sort.h"
