// Every value in a state, one after the other. Why: what a state's checksum counts and what is looked at for NaN are
// the same values, named once by each struct's state().
#pragma once
#include <type_traits>

#include "core/types.hpp"

namespace halfroll {

template <class T, class Visit>
void each_value(const T& x, Visit& visit);

namespace parts {

template <class Visit, class T>
void visit_in(const T& x, Visit& visit) {  // a struct names its own
  each_value(x.state(), visit);
}
template <class Visit, class... T>
void visit_in(const std::tuple<T...>& all, Visit& visit) {
  std::apply([&visit](const auto&... each) { (each_value(each, visit), ...); }, all);
}
template <class Visit, class T, std::size_t N>
void visit_in(const std::array<T, N>& all, Visit& visit) {
  for (const T& each : all) each_value(each, visit);
}
template <class Visit, class T>
void visit_in(const std::optional<T>& perhaps, Visit& visit) {
  visit(perhaps.has_value());
  if (perhaps) each_value(*perhaps, visit);
}
template <class Visit, int Rows, int Columns>
void visit_in(const Eigen::Matrix<float, Rows, Columns>& m, Visit& visit) {
  for (int i = 0; i < Rows * Columns; ++i) visit(m.data()[i]);
}

}  // namespace parts

/// Calls `visit` with each float, integer, enumerator and bool of a value, tuple, array, optional, vector or struct
/// with a state(), in order. An optional is its presence, then its content.
template <class T, class Visit>
void each_value(const T& x, Visit& visit) {
  if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
    visit(x);
  } else {
    parts::visit_in(x, visit);
  }
}

}  // namespace halfroll
