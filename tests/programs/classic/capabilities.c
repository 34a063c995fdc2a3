/* SPDX-License-Identifier: Apache-2.0 */
/* A program that asks for everything at its start, as launchers and bug reports do, and gives up if
   an answer makes no sense. It then fills a buffer whose size follows from the answers. */
#include <optix.h>
#include <optixu/optixu.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

extern const char device_ptx[];

static int faults = 0;

static void expect(int holds, const char* what) {
    if (!holds) {
        printf("unexpected: %s\n", what);
        ++faults;
    }
}
#define EXPECT(condition) expect(condition, #condition)
#define SUCCEEDS(call) expect((call) == RT_SUCCESS, #call)

static void ask_versions(void) {
    unsigned int version = 0;
    SUCCEEDS(rtGetVersion(&version));
    fprintf(stderr, "OptiX %u.%u.%u\n", version / 10000, version / 100 % 100, version % 100);
    EXPECT(version >= 60000 && version < 70000);
}

static void ask_device(int device, unsigned int devices) {
    char name[256] = "", bus[16] = "";
    int capability[2] = {0, 0}, number = -1, compatible[65];
    RTsize memory = 0;
    unsigned int i;
    static const RTdeviceattribute numbers[] = {RT_DEVICE_ATTRIBUTE_MAX_THREADS_PER_BLOCK,
                                                RT_DEVICE_ATTRIBUTE_CLOCK_RATE,
                                                RT_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT,
                                                RT_DEVICE_ATTRIBUTE_EXECUTION_TIMEOUT_ENABLED,
                                                RT_DEVICE_ATTRIBUTE_MAX_HARDWARE_TEXTURE_COUNT,
                                                RT_DEVICE_ATTRIBUTE_TCC_DRIVER,
                                                RT_DEVICE_ATTRIBUTE_CUDA_DEVICE_ORDINAL};
    SUCCEEDS(rtDeviceGetAttribute(device, RT_DEVICE_ATTRIBUTE_NAME, sizeof name, name));
    SUCCEEDS(rtDeviceGetAttribute(device, RT_DEVICE_ATTRIBUTE_PCI_BUS_ID, sizeof bus, bus));
    SUCCEEDS(rtDeviceGetAttribute(device, RT_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY, sizeof capability,
                                  &capability));
    SUCCEEDS(
        rtDeviceGetAttribute(device, RT_DEVICE_ATTRIBUTE_TOTAL_MEMORY, sizeof memory, &memory));
    SUCCEEDS(rtDeviceGetAttribute(device, RT_DEVICE_ATTRIBUTE_COMPATIBLE_DEVICES,
                                  (devices + 1) * sizeof(int), compatible));
    fprintf(stderr, "device %d: %s (%s), %d.%d, %llu bytes\n", device, name, bus, capability[0],
            capability[1], (unsigned long long)memory);
    EXPECT(strlen(name) > 0 && strlen(bus) < 14);
    EXPECT(capability[0] >= 3 && capability[1] >= 0 && memory > 0);
    EXPECT(compatible[0] >= 1 && compatible[0] <= (int)devices && compatible[1] >= 0);
    for (i = 0; i < sizeof numbers / sizeof numbers[0]; ++i) {
        number = -1;
        SUCCEEDS(rtDeviceGetAttribute(device, numbers[i], sizeof number, &number));
        EXPECT(number >= 0);
    }
    EXPECT(rtDeviceGetAttribute(device, RT_DEVICE_ATTRIBUTE_CLOCK_RATE, 1, &number) ==
           RT_ERROR_INVALID_VALUE);
}

static void ask_context(RTcontext context, unsigned int devices) {
    unsigned int used = 0, i;
    int ordinals[64], threads = 0, textures = 0, paging = -1;
    RTsize memory = 0, host = 0, stack = 0, print = 0;
    unsigned int depth = 0, callables = 0;
    SUCCEEDS(rtContextGetDeviceCount(context, &used));
    EXPECT(used >= 1 && used <= devices);
    SUCCEEDS(rtContextGetDevices(context, ordinals));
    for (i = 0; i < used; ++i) {
        EXPECT(ordinals[i] >= 0 && ordinals[i] < (int)devices);
        SUCCEEDS(rtContextGetAttribute(
            context,
            (RTcontextattribute)(RT_CONTEXT_ATTRIBUTE_AVAILABLE_DEVICE_MEMORY + ordinals[i]),
            sizeof memory, &memory));
        EXPECT(memory > 0);
    }
    SUCCEEDS(rtContextGetAttribute(context, RT_CONTEXT_ATTRIBUTE_MAX_TEXTURE_COUNT, sizeof textures,
                                   &textures));
    SUCCEEDS(rtContextGetAttribute(context, RT_CONTEXT_ATTRIBUTE_CPU_NUM_THREADS, sizeof threads,
                                   &threads));
    SUCCEEDS(
        rtContextGetAttribute(context, RT_CONTEXT_ATTRIBUTE_USED_HOST_MEMORY, sizeof host, &host));
    SUCCEEDS(rtContextGetAttribute(context, RT_CONTEXT_ATTRIBUTE_GPU_PAGING_ACTIVE, sizeof paging,
                                   &paging));
    EXPECT(textures > 0 && threads > 0 && paging == 0);
    SUCCEEDS(rtContextGetStackSize(context, &stack));
    SUCCEEDS(rtContextGetPrintBufferSize(context, &print));
    SUCCEEDS(rtContextGetMaxTraceDepth(context, &depth));
    SUCCEEDS(rtContextGetMaxCallableProgramDepth(context, &callables));
    EXPECT(stack > 0 && print > 0 && depth > 0 && callables > 0);
}

static void ask_names(void) {
    char name[64], previous[64] = "";
    int type, known = 0;
    size_t size = 0;
    for (type = RT_OBJECTTYPE_UNKNOWN; type <= RT_OBJECTTYPE_UNSIGNED_LONG_LONG4; ++type)
        if (rtuNameForType((RTobjecttype)type, name, sizeof name) == RT_SUCCESS) {
            EXPECT(strlen(name) > 2 && strcmp(name, previous) != 0);
            strcpy(previous, name);
            ++known;
        }
    EXPECT(known >= 0x229 - 0x200 + 1);
    SUCCEEDS(rtuGetSizeForRTformat(RT_FORMAT_FLOAT4, &size));
    EXPECT(size == 16);
    SUCCEEDS(rtuGetSizeForRTformat(RT_FORMAT_UNSIGNED_SHORT3, &size));
    EXPECT(size == 6);
}

static void ask_errors(RTcontext context) {
    static const RTresult codes[] = {RT_SUCCESS,
                                     RT_TIMEOUT_CALLBACK,
                                     RT_ERROR_INVALID_CONTEXT,
                                     RT_ERROR_INVALID_VALUE,
                                     RT_ERROR_MEMORY_ALLOCATION_FAILED,
                                     RT_ERROR_TYPE_MISMATCH,
                                     RT_ERROR_VARIABLE_NOT_FOUND,
                                     RT_ERROR_VARIABLE_REDECLARED,
                                     RT_ERROR_ILLEGAL_SYMBOL,
                                     RT_ERROR_INVALID_SOURCE,
                                     RT_ERROR_VERSION_MISMATCH,
                                     RT_ERROR_OBJECT_CREATION_FAILED,
                                     RT_ERROR_NO_DEVICE,
                                     RT_ERROR_INVALID_DEVICE,
                                     RT_ERROR_INVALID_IMAGE,
                                     RT_ERROR_FILE_NOT_FOUND,
                                     RT_ERROR_ALREADY_MAPPED,
                                     RT_ERROR_INVALID_DRIVER_VERSION,
                                     RT_ERROR_CONTEXT_CREATION_FAILED,
                                     RT_ERROR_RESOURCE_NOT_REGISTERED,
                                     RT_ERROR_RESOURCE_ALREADY_REGISTERED,
                                     RT_ERROR_LAUNCH_FAILED,
                                     RT_ERROR_NOT_SUPPORTED,
                                     RT_ERROR_UNKNOWN};
    unsigned int i;
    char kept[256] = "";
    for (i = 0; i < sizeof codes / sizeof codes[0]; ++i) {
        const char *without = 0, *with = 0;
        rtContextGetErrorString(0, codes[i], &without);
        EXPECT(without && strlen(without) > 3 && strcmp(without, kept) != 0);
        if (without)
            strncpy(kept, without, sizeof kept - 1);
        rtContextGetErrorString(context, codes[i], &with);
        EXPECT(with && strlen(with) > 3);
    }
    {
        RTbuffer none = 0;
        const char* text = 0;
        const RTresult result = rtBufferCreate(context, 0, &none);
        EXPECT(result == RT_ERROR_INVALID_VALUE && none == 0);
        rtContextGetErrorString(context, result, &text);
        EXPECT(text && strstr(text, "rtBufferCreate") != 0);
    }
}

static void fill(RTcontext context, unsigned int devices) {
    RTprogram program = 0;
    RTbuffer buffer = 0;
    RTvariable variable = 0;
    void* data = 0;
    unsigned int i, wrong = 0;
    const unsigned int count = 64 * devices;
    SUCCEEDS(rtContextSetEntryPointCount(context, 1));
    SUCCEEDS(rtProgramCreateFromPTXString(context, device_ptx, "fill", &program));
    SUCCEEDS(rtContextSetRayGenerationProgram(context, 0, program));
    SUCCEEDS(rtBufferCreate(context, RT_BUFFER_OUTPUT, &buffer));
    SUCCEEDS(rtBufferSetFormat(buffer, RT_FORMAT_UNSIGNED_INT));
    SUCCEEDS(rtBufferSetSize1D(buffer, count));
    SUCCEEDS(rtContextDeclareVariable(context, "numbers", &variable));
    SUCCEEDS(rtVariableSetObject(variable, buffer));
    SUCCEEDS(rtContextValidate(context));
    SUCCEEDS(rtContextLaunch1D(context, 0, count));
    SUCCEEDS(rtBufferMap(buffer, &data));
    for (i = 0; data && i < count; ++i)
        wrong += ((const unsigned int*)data)[i] != i * i + 1;
    EXPECT(data && wrong == 0);
    SUCCEEDS(rtBufferUnmap(buffer));
}

int main(void) {
    RTcontext context = 0;
    unsigned int devices = 0, i;
    int rtx = 1;
    const RTresult set = rtGlobalSetAttribute(RT_GLOBAL_ATTRIBUTE_ENABLE_RTX, sizeof rtx, &rtx);
    expect(set == RT_SUCCESS, "the strategy can be chosen before there is a context");
    ask_versions();
    SUCCEEDS(rtDeviceGetDeviceCount(&devices));
    EXPECT(devices > 0);
    for (i = 0; i < devices; ++i)
        ask_device((int)i, devices);
    ask_names();
    if (rtContextCreate(&context) != RT_SUCCESS) {
        printf("no context\n");
        return 1;
    }
    ask_context(context, devices);
    ask_errors(context);
    fill(context, devices);
    SUCCEEDS(rtContextDestroy(context));
    EXPECT(rtContextDestroy(context) == RT_ERROR_INVALID_VALUE);
    if (!faults)
        printf("ok\n");
    return faults;
}
