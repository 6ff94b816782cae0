// The options with which every program of a build with the address sanitizer starts. Up to GCC 13 and LLVM 16 its runtime
// reads the two words in front of a thread-local block of a loaded module as the header that glibc wrote before
// version 2.25, whenever the block lies at an offset of 16 in its page. The leak check at the end of a program then reads a
// range that does not exist, and the program ends with "LeakSanitizer has encountered a fatal error" (google/sanitizers,
// issue 1322). The C library asks malloc for these blocks, and so they are still known to the leak check without the
// interceptor.

extern "C" __attribute__((visibility("default"))) const char* __asan_default_options();

extern "C" const char* __asan_default_options() { return "intercept_tls_get_addr=0"; }
