// SPDX-License-Identifier: Apache-2.0
// All builder kernels, compiled to PTX when the library is built; builder.cpp launches them.
#include "bvh/gpu/arrange.h"
#include "bvh/gpu/collapse.h"
#include "bvh/gpu/finish.h"
#include "bvh/gpu/hierarchy.h"
#include "bvh/gpu/micromaps.h"
#include "bvh/gpu/presplit.h"
#include "bvh/gpu/references.h"
#include "bvh/gpu/refit.h"
#include "bvh/gpu/relocate.h"
#include "bvh/gpu/sort.h"
