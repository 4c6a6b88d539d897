/* What the shared library shows to the outside; everything else is static or hidden. */
#ifndef EXPORT_H
#define EXPORT_H

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

#endif
