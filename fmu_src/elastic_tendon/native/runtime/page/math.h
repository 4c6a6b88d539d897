/* For WebAssembly, where there is no C library: functions that processors lack are imported from
 * the page's own Math. */
#ifndef PAGE_MATH_H
#define PAGE_MATH_H

/* the label keeps the compiler from taking it for what it knows itself, which is not imported */
#define OF_PAGE(name) \
  __asm__("page_" #name) __attribute__((import_module("Math"), import_name(#name)))

double acos(double) OF_PAGE(acos);
double asin(double) OF_PAGE(asin);
double atan(double) OF_PAGE(atan);
double atan2(double, double) OF_PAGE(atan2);
double cos(double) OF_PAGE(cos);
double cosh(double) OF_PAGE(cosh);
double exp(double) OF_PAGE(exp);
double log(double) OF_PAGE(log);
double pow(double, double) OF_PAGE(pow);
double sin(double) OF_PAGE(sin);
double sinh(double) OF_PAGE(sinh);
double tan(double) OF_PAGE(tan);
double tanh(double) OF_PAGE(tanh);

double ceil(double);
double copysign(double, double);
double fabs(double);
double floor(double);
double fmax(double, double);
double fmin(double, double);
double fmod(double, double);
double sqrt(double);
double trunc(double);

#define isfinite __builtin_isfinite
#define isnan __builtin_isnan
#define INFINITY __builtin_inf()
#define NAN __builtin_nan("")

#endif
