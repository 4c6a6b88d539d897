/* What compilers spell differently. Only what is marked EXPORT is seen from outside the library. */
#ifndef COMPILERS_H
#define COMPILERS_H

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif

#if defined(__GNUC__)
#define ALWAYS_INLINE static inline __attribute__((always_inline))
#define NEVER_INLINE __attribute__((noinline))
#define PRINTS(text, first) __attribute__((format(printf, text, first)))
#else
#define ALWAYS_INLINE static inline
#define NEVER_INLINE
#define PRINTS(text, first)
#endif

#endif
