// A Vulkan layer for frame times on a GPU without a monitor: X in memory (Xvfb) has windows, but a GPU's driver shows
// nothing in them. Here any X window has a surface, and its swapchain is of images that are drawn and waited for as any
// others, and that nobody looks at. Nothing is copied to the window, and nothing waits for a screen.
//
// One instance and one device at a time. Swapchains submit to the program's queues, so those are locked here.
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define VK_NO_PROTOTYPES
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#define IMAGES_AT_MOST 8

typedef struct {
    uint32_t count, next;
    VkImage images[IMAGES_AT_MOST];
    VkDeviceMemory memory[IMAGES_AT_MOST];
} Swapchain;

#define INSTANCE_FUNCTIONS(X) \
    X(GetPhysicalDeviceQueueFamilyProperties) X(GetPhysicalDeviceMemoryProperties)
#define DEVICE_FUNCTIONS(X) \
    X(GetDeviceQueue) X(QueueSubmit) X(QueueSubmit2) X(QueueSubmit2KHR) X(CreateImage) X(DestroyImage) \
    X(GetImageMemoryRequirements) X(AllocateMemory) X(FreeMemory) X(BindImageMemory)

static PFN_vkGetInstanceProcAddr next_instance_function;
static PFN_vkGetDeviceProcAddr next_device_function;
#define X(name) static PFN_vk##name next##name;
INSTANCE_FUNCTIONS(X)
DEVICE_FUNCTIONS(X)
#undef X
static VkPhysicalDeviceMemoryProperties memory_properties;
// What signals that an image is free: the queue that presented last, or the device's first.
static VkQueue presents;
static pthread_mutex_t queues = PTHREAD_MUTEX_INITIALIZER;

static VkLayerInstanceCreateInfo *instance_link(const VkInstanceCreateInfo *info) {
    VkLayerInstanceCreateInfo *link = (VkLayerInstanceCreateInfo *)info->pNext;
    while (link &&
           !(link->sType == VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO && link->function == VK_LAYER_LINK_INFO))
        link = (VkLayerInstanceCreateInfo *)link->pNext;
    return link;
}

static VkLayerDeviceCreateInfo *device_link(const VkDeviceCreateInfo *info) {
    VkLayerDeviceCreateInfo *link = (VkLayerDeviceCreateInfo *)info->pNext;
    while (link &&
           !(link->sType == VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO && link->function == VK_LAYER_LINK_INFO))
        link = (VkLayerDeviceCreateInfo *)link->pNext;
    return link;
}

static VkResult CreateInstance(const VkInstanceCreateInfo *info, const VkAllocationCallbacks *allocator,
                               VkInstance *instance) {
    VkLayerInstanceCreateInfo *link = instance_link(info);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    next_instance_function = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    PFN_vkCreateInstance create = (PFN_vkCreateInstance)next_instance_function(NULL, "vkCreateInstance");
    VkResult result = create(info, allocator, instance);
    if (result != VK_SUCCESS) return result;
#define X(name) next##name = (PFN_vk##name)next_instance_function(*instance, "vk" #name);
    INSTANCE_FUNCTIONS(X)
#undef X
    return VK_SUCCESS;
}

static VkResult CreateDevice(VkPhysicalDevice gpu, const VkDeviceCreateInfo *info,
                             const VkAllocationCallbacks *allocator, VkDevice *device) {
    VkLayerDeviceCreateInfo *link = device_link(info);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    PFN_vkGetInstanceProcAddr next = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    next_device_function = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    PFN_vkCreateDevice create = (PFN_vkCreateDevice)next(NULL, "vkCreateDevice");
    VkResult result = create(gpu, info, allocator, device);
    if (result != VK_SUCCESS) return result;
#define X(name) next##name = (PFN_vk##name)next_device_function(*device, "vk" #name);
    DEVICE_FUNCTIONS(X)
#undef X
    nextGetPhysicalDeviceMemoryProperties(gpu, &memory_properties);
    nextGetDeviceQueue(*device, info->pQueueCreateInfos[0].queueFamilyIndex, 0, &presents);
    return VK_SUCCESS;
}

// A surface is nothing but a name for itself.
static VkResult create_surface(VkInstance instance, const void *info, const VkAllocationCallbacks *allocator,
                               VkSurfaceKHR *surface) {
    (void)instance, (void)info, (void)allocator;
    void *name = malloc(1);
    *surface = (VkSurfaceKHR)(uintptr_t)name;
    return name ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY;
}

static void DestroySurfaceKHR(VkInstance instance, VkSurfaceKHR surface, const VkAllocationCallbacks *allocator) {
    (void)instance, (void)allocator;
    free((void *)(uintptr_t)surface);
}

static VkBool32 draws(VkPhysicalDevice gpu, uint32_t family) {
    VkQueueFamilyProperties families[16];
    uint32_t count = 16;
    nextGetPhysicalDeviceQueueFamilyProperties(gpu, &count, families);
    return family < count && (families[family].queueFlags & VK_QUEUE_GRAPHICS_BIT);
}

static VkBool32 presentation_support(VkPhysicalDevice gpu, uint32_t family, void *display, uintptr_t visual) {
    (void)display, (void)visual;
    return draws(gpu, family);
}

static VkResult GetPhysicalDeviceSurfaceSupportKHR(VkPhysicalDevice gpu, uint32_t family, VkSurfaceKHR surface,
                                                   VkBool32 *supported) {
    (void)surface;
    *supported = draws(gpu, family);
    return VK_SUCCESS;
}

static VkResult GetPhysicalDeviceSurfaceCapabilitiesKHR(VkPhysicalDevice gpu, VkSurfaceKHR surface,
                                                        VkSurfaceCapabilitiesKHR *seen) {
    (void)gpu, (void)surface;
    // An extent of ~0 lets the program choose it.
    *seen = (VkSurfaceCapabilitiesKHR){
        .minImageCount = 2,
        .maxImageCount = IMAGES_AT_MOST,
        .currentExtent = {~0u, ~0u},
        .minImageExtent = {1, 1},
        .maxImageExtent = {16384, 16384},
        .maxImageArrayLayers = 1,
        .supportedTransforms = VK_SURFACE_TRANSFORM_IDENTITY_BIT_KHR,
        .currentTransform = VK_SURFACE_TRANSFORM_IDENTITY_BIT_KHR,
        .supportedCompositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR | VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR,
        .supportedUsageFlags = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                               VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
    };
    return VK_SUCCESS;
}

// As Vulkan lists things: how many there are where nobody asks for them, else as many as fit.
static VkResult list(const void *all, uint32_t there, size_t size, uint32_t *count, void *to) {
    uint32_t fit = !to || *count > there ? there : *count;
    if (to) memcpy(to, all, fit * size);
    *count = fit;
    return fit < there ? VK_INCOMPLETE : VK_SUCCESS;
}

static VkResult GetPhysicalDeviceSurfaceFormatsKHR(VkPhysicalDevice gpu, VkSurfaceKHR surface, uint32_t *count,
                                                   VkSurfaceFormatKHR *to) {
    static const VkSurfaceFormatKHR formats[] = {{VK_FORMAT_B8G8R8A8_UNORM, VK_COLOR_SPACE_SRGB_NONLINEAR_KHR},
                                                 {VK_FORMAT_R8G8B8A8_UNORM, VK_COLOR_SPACE_SRGB_NONLINEAR_KHR}};
    (void)gpu, (void)surface;
    return list(formats, 2, sizeof *formats, count, to);
}

static VkResult GetPhysicalDeviceSurfacePresentModesKHR(VkPhysicalDevice gpu, VkSurfaceKHR surface, uint32_t *count,
                                                        VkPresentModeKHR *to) {
    static const VkPresentModeKHR modes[] = {VK_PRESENT_MODE_IMMEDIATE_KHR, VK_PRESENT_MODE_FIFO_KHR};
    (void)gpu, (void)surface;
    return list(modes, 2, sizeof *modes, count, to);
}

static void DestroySwapchainKHR(VkDevice device, VkSwapchainKHR handle, const VkAllocationCallbacks *allocator) {
    Swapchain *chain = (Swapchain *)(uintptr_t)handle;
    (void)allocator;
    if (!chain) return;
    for (uint32_t i = 0; i < chain->count; i++) {
        nextDestroyImage(device, chain->images[i], NULL);
        nextFreeMemory(device, chain->memory[i], NULL);
    }
    free(chain);
}

static VkResult make_image(VkDevice device, const VkSwapchainCreateInfoKHR *info, VkImage *image,
                           VkDeviceMemory *memory) {
    VkImageCreateInfo wanted = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .imageType = VK_IMAGE_TYPE_2D,
        .format = info->imageFormat,
        .extent = {info->imageExtent.width, info->imageExtent.height, 1},
        .mipLevels = 1,
        .arrayLayers = info->imageArrayLayers,
        .samples = VK_SAMPLE_COUNT_1_BIT,
        .tiling = VK_IMAGE_TILING_OPTIMAL,
        .usage = info->imageUsage,
        .sharingMode = info->imageSharingMode,
        .queueFamilyIndexCount = info->queueFamilyIndexCount,
        .pQueueFamilyIndices = info->pQueueFamilyIndices,
    };
    VkResult result = nextCreateImage(device, &wanted, NULL, image);
    if (result != VK_SUCCESS) return result;
    VkMemoryRequirements needs;
    nextGetImageMemoryRequirements(device, *image, &needs);
    uint32_t type = 0;
    while (type < memory_properties.memoryTypeCount &&
           !(needs.memoryTypeBits & 1u << type &&
             memory_properties.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT))
        type++;
    VkMemoryAllocateInfo size = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, NULL, needs.size, type};
    result = nextAllocateMemory(device, &size, NULL, memory);
    return result == VK_SUCCESS ? nextBindImageMemory(device, *image, *memory, 0) : result;
}

static VkResult CreateSwapchainKHR(VkDevice device, const VkSwapchainCreateInfoKHR *info,
                                   const VkAllocationCallbacks *allocator, VkSwapchainKHR *handle) {
    Swapchain *chain = calloc(1, sizeof *chain);
    if (!chain) return VK_ERROR_OUT_OF_HOST_MEMORY;
    VkResult result = VK_SUCCESS;
    while (result == VK_SUCCESS && chain->count < info->minImageCount && chain->count < IMAGES_AT_MOST) {
        result = make_image(device, info, &chain->images[chain->count], &chain->memory[chain->count]);
        chain->count++;
    }
    *handle = (VkSwapchainKHR)(uintptr_t)chain;
    if (result == VK_SUCCESS) return VK_SUCCESS;
    DestroySwapchainKHR(device, *handle, allocator);
    *handle = VK_NULL_HANDLE;
    return result;
}

static VkResult GetSwapchainImagesKHR(VkDevice device, VkSwapchainKHR handle, uint32_t *count, VkImage *to) {
    const Swapchain *chain = (const Swapchain *)(uintptr_t)handle;
    (void)device;
    return list(chain->images, chain->count, sizeof *chain->images, count, to);
}

// The next image is free once the queue is done with what it has, for nobody looks at one.
static VkResult AcquireNextImageKHR(VkDevice device, VkSwapchainKHR handle, uint64_t timeout, VkSemaphore semaphore,
                                    VkFence fence, uint32_t *index) {
    Swapchain *chain = (Swapchain *)(uintptr_t)handle;
    (void)device, (void)timeout;
    *index = chain->next++ % chain->count;
    VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                           .signalSemaphoreCount = semaphore != VK_NULL_HANDLE,
                           .pSignalSemaphores = &semaphore};
    pthread_mutex_lock(&queues);
    VkResult result = nextQueueSubmit(presents, 1, &submit, fence);
    pthread_mutex_unlock(&queues);
    return result;
}

static VkResult QueuePresentKHR(VkQueue queue, const VkPresentInfoKHR *info) {
    VkPipelineStageFlags stages[16];
    if (info->waitSemaphoreCount > 16) return VK_ERROR_OUT_OF_HOST_MEMORY;
    for (int i = 0; i < 16; i++) stages[i] = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                           .waitSemaphoreCount = info->waitSemaphoreCount,
                           .pWaitSemaphores = info->pWaitSemaphores,
                           .pWaitDstStageMask = stages};
    pthread_mutex_lock(&queues);
    presents = queue;
    VkResult result = nextQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE);
    pthread_mutex_unlock(&queues);
    for (uint32_t i = 0; info->pResults && i < info->swapchainCount; i++) info->pResults[i] = result;
    return result;
}

static VkResult QueueSubmit(VkQueue queue, uint32_t count, const VkSubmitInfo *submits, VkFence fence) {
    pthread_mutex_lock(&queues);
    VkResult result = nextQueueSubmit(queue, count, submits, fence);
    pthread_mutex_unlock(&queues);
    return result;
}

static VkResult QueueSubmit2(VkQueue queue, uint32_t count, const VkSubmitInfo2 *submits, VkFence fence) {
    pthread_mutex_lock(&queues);
    VkResult result = (nextQueueSubmit2 ? nextQueueSubmit2 : nextQueueSubmit2KHR)(queue, count, submits, fence);
    pthread_mutex_unlock(&queues);
    return result;
}

static PFN_vkVoidFunction GetInstanceProcAddr(VkInstance instance, const char *name);
static PFN_vkVoidFunction GetDeviceProcAddr(VkDevice device, const char *name);

typedef struct {
    const char *name;
    PFN_vkVoidFunction function;
} Function;

static const Function of_instances[] = {
#define F(name) {"vk" #name, (PFN_vkVoidFunction)name}
    F(GetInstanceProcAddr),
    F(CreateInstance),
    F(CreateDevice),
    F(DestroySurfaceKHR),
    {"vkCreateXlibSurfaceKHR", (PFN_vkVoidFunction)create_surface},
    {"vkCreateXcbSurfaceKHR", (PFN_vkVoidFunction)create_surface},
    {"vkGetPhysicalDeviceXlibPresentationSupportKHR", (PFN_vkVoidFunction)presentation_support},
    {"vkGetPhysicalDeviceXcbPresentationSupportKHR", (PFN_vkVoidFunction)presentation_support},
    F(GetPhysicalDeviceSurfaceSupportKHR),
    F(GetPhysicalDeviceSurfaceCapabilitiesKHR),
    F(GetPhysicalDeviceSurfaceFormatsKHR),
    F(GetPhysicalDeviceSurfacePresentModesKHR),
};
static const Function of_devices[] = {
    F(GetDeviceProcAddr),     F(CreateSwapchainKHR),  F(DestroySwapchainKHR),
    F(GetSwapchainImagesKHR), F(AcquireNextImageKHR), F(QueuePresentKHR),
    F(QueueSubmit),           F(QueueSubmit2),        {"vkQueueSubmit2KHR", (PFN_vkVoidFunction)QueueSubmit2},
};
#undef F

static PFN_vkVoidFunction found(const Function *functions, size_t count, const char *name) {
    for (size_t i = 0; i < count; i++)
        if (!strcmp(functions[i].name, name)) return functions[i].function;
    return NULL;
}

static PFN_vkVoidFunction GetDeviceProcAddr(VkDevice device, const char *name) {
    PFN_vkVoidFunction own = found(of_devices, sizeof of_devices / sizeof *of_devices, name);
    return own ? own : next_device_function(device, name);
}

static PFN_vkVoidFunction GetInstanceProcAddr(VkInstance instance, const char *name) {
    PFN_vkVoidFunction own = found(of_instances, sizeof of_instances / sizeof *of_instances, name);
    if (!own) own = found(of_devices, sizeof of_devices / sizeof *of_devices, name);
    return own ? own : next_instance_function ? next_instance_function(instance, name) : NULL;
}

VK_LAYER_EXPORT VkResult vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface *loader) {
    loader->loaderLayerInterfaceVersion = 2;
    loader->pfnGetInstanceProcAddr = GetInstanceProcAddr;
    loader->pfnGetDeviceProcAddr = GetDeviceProcAddr;
    loader->pfnGetPhysicalDeviceProcAddr = NULL;
    return VK_SUCCESS;
}
