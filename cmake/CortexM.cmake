# Cross compilation for Cortex-M with the GNU tools and newlib-nano. HALFROLL_MCU: cortex-m4 or cortex-m7, both with a
# single-precision FPU, so that a double that slips in shows as a call to __aeabi_d*.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR arm)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_ASM_COMPILER arm-none-eabi-gcc)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES HALFROLL_MCU)
if(HALFROLL_MCU STREQUAL "cortex-m7")
  set(_fpu fpv5-sp-d16)
else()
  set(_fpu fpv4-sp-d16)
endif()
set(CMAKE_CXX_FLAGS_INIT "-mcpu=${HALFROLL_MCU} -mthumb -mfloat-abi=hard -mfpu=${_fpu} -ffunction-sections -fdata-sections \
-fno-exceptions -fno-rtti -fno-threadsafe-statics -fno-use-cxa-atexit -fno-unwind-tables -fno-asynchronous-unwind-tables")
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG" CACHE STRING "smaller than -O3, and no slower without caches")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-nostartfiles -Wl,--gc-sections --specs=nano.specs --specs=nosys.specs")
