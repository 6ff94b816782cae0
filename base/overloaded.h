// Makes one callable of several, for std::visit: it does not compile if a kind is forgotten.
#pragma once

namespace occam {

template <class... Calls>
struct Overloaded : Calls... {
    using Calls::operator()...;
};
template <class... Calls>
Overloaded(Calls...) -> Overloaded<Calls...>;

}  // namespace occam
