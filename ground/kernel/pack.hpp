// Four samples at once. Why: the inverse dynamics are written once, for one scalar type; with this one the compiler
// turns every operation into vector instructions, with the same bits on every machine.
#pragma once
#include <cmath>

namespace halfroll::planner {

struct Pack {
  static constexpr int kWidth = 4;
  typedef double Lanes __attribute__((vector_size(kWidth * sizeof(double))));
  Lanes v;
};

inline Pack splat(double x) { return {Pack::Lanes{x, x, x, x}}; }
inline Pack operator+(const Pack& a, const Pack& b) { return {a.v + b.v}; }
inline Pack operator-(const Pack& a, const Pack& b) { return {a.v - b.v}; }
inline Pack operator*(const Pack& a, const Pack& b) { return {a.v * b.v}; }
inline Pack operator*(double a, const Pack& b) { return {a * b.v}; }
inline Pack operator+(const Pack& a, double b) { return {a.v + b}; }

inline Pack each(const Pack& a, double (*f)(double)) {
  Pack out = a;
  for (int i = 0; i < Pack::kWidth; ++i) out.v[i] = f(a.v[i]);
  return out;
}
inline Pack inverse(const Pack& a) { return {1.0 / a.v}; }
inline Pack inverse_sqrt(const Pack& a) {
  Pack root = a;
  for (int i = 0; i < Pack::kWidth; ++i) root.v[i] = std::sqrt(a.v[i]);
  return inverse(root);
}
inline Pack sine(const Pack& a) {
  return each(a, [](double x) { return std::sin(x); });
}
inline Pack cosine(const Pack& a) {
  return each(a, [](double x) { return std::cos(x); });
}

// The same operations for one sample.
inline double inverse(double a) { return 1.0 / a; }
inline double inverse_sqrt(double a) { return 1.0 / std::sqrt(a); }
inline double sine(double a) { return std::sin(a); }
inline double cosine(double a) { return std::cos(a); }

}  // namespace halfroll::planner
