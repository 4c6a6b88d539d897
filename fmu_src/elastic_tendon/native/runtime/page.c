/* What a page simulates with: as `simulation.c`, for WebAssembly, where there is no C library.
 * `page/` has the headers of what stands in for it: here, and in the page's own Math. */
#include "model.c"

#include "solver.c"

#include "simulate.c"

#define PAGE 65536 /* bytes by which memory grows */

extern unsigned char __heap_base; /* of the linker: where memory is free */

/* The page asks for its arrays once, and then a simulation for its work, again and again: what is
 * freed is the last that was given. */
static size_t used, last;

EXPORT void *malloc(size_t size) {
  const size_t start = (size_t)&__heap_base + used;
  const size_t pages = (start + size + PAGE - 1) / PAGE, present = __builtin_wasm_memory_size(0);
  if (pages > present && __builtin_wasm_memory_grow(0, pages - present) == (size_t)-1) return NULL;
  last = used;
  used += (size + 15) / 16 * 16;
  return (void *)start;
}

void free(void *where) { used = last; }

/* Nobody interrupts. */
time_t time(time_t *result) { return 0; }
