#include "thesis/groups.hpp"

namespace servohil::thesis {
namespace {

/// A printed number, and what is right where it is not: right empty: it is.
struct Printed {
  const char* text;
  const char* right;
  const char* errata;
  const char* why;
};

constexpr const char* kFromB = "follows from the printed B1 to B6: P4 = 5.690, a3 rounded to 1300";
constexpr const char* kArithmetic = "the thesis' arithmetic, in the last digit";
constexpr const char* kNoSecondTerm =
    "the row of s^1 repeats a3: c1 = a3 - a1 b2 / b1, its second term is left out";
constexpr const char* kOtherRc =
    "does not follow from the stated R and C; (G.15) gives this, with the same verdict";

std::optional<Reason> ReasonOf(const Printed& p) {
  if (*p.right == 0) return std::nullopt;
  return Reason{p.right, p.errata, p.why};
}

void Numbers(Group& g, const std::string& what, const char* unit, std::initializer_list<Printed> printed,
             const linear::Polynomial& ours) {
  int i = 0;
  for (const Printed& p : printed) {
    g.Number(printed.size() > 1 ? what + std::to_string(i) : what, unit, p.text, ours[i], ReasonOf(p));
    ++i;
  }
}

/// Elements that the thesis prints: first column, then second, row by row.
struct RouthRow {
  Printed first;
  Printed second;
};

/// Only what the array adds to the polynomial: from its third row.
void Rows(Group& g, std::initializer_list<RouthRow> printed, const linear::RouthArray& ours) {
  std::size_t row = 2;
  for (const RouthRow& p : printed) {
    const std::string power = "Routh s^" + std::to_string(static_cast<std::size_t>(ours.row_count) - 1 - row);
    g.Number(power + ", first", "", p.first.text, ours.rows[row][0], ReasonOf(p.first));
    if (*p.second.text != 0)
      g.Number(power + ", second", "", p.second.text, ours.rows[row][1], ReasonOf(p.second));
    ++row;
  }
}

/// The thesis' array against the one that its own printed polynomial has: its arithmetic alone.
Group Arithmetic(const char* where, const Case& c, const linear::Polynomial& printed,
                 std::initializer_list<RouthRow> rows) {
  Group g(std::string(where) + ", Routh array of the polynomial as printed", c);
  Rows(g, rows, linear::Routh(printed));
  return g;
}

constexpr Printed Good(const char* text) {
  return {text, "", "", ""};
}
constexpr Printed None() {
  return {"", "", "", ""};
}
/// A deviation inherited from the printed coefficients.
constexpr Printed Near(const char* text, const char* right) {
  return {text, right, "1", kFromB};
}
constexpr Printed Sloppy(const char* text, const char* right) {
  return {text, right, "new", kArithmetic};
}

void Uncompensated(const MakeCase& make, Groups& groups) {
  const Case low = make({});
  const linear::TransferFunction t = linear::ThesisTransferFunction(low.Coefficients());
  Group g("(3.18), (B.19): beta = 110,000 psi, a4 = 0.2901", low);
  Numbers(g, "K", "", {Good("4.662e6")}, t.numerator);
  Numbers(g, "a", "",
          {{"155.0e-6", "155.847e-6", "14", "printed 155.0 in (3.18) and 155.9 in (B.19)"},
           Near("142.9e-3", "142.393e-3"),
           Good("191.4"),
           Near("176.1e3", "175.624e3"),
           Near("10.89e6", "10.8817e6")},
          t.denominator);
  g.Number("a0 (B.19)", "", "155.9e-6", t.denominator[0], Reason{"155.847e-6", "14", "155.85"});
  g.Number("a2 (B.19)", "", "191.44", t.denominator[2], Reason{"191.412", "1", kFromB});
  Rows(g,
       {{{"-680.3e-3", "-805.375e-3", "new",
          "difference of 191.4 and 192.2: decided by the third digit of a0 to a3"},
         Near("10.89e6", "10.8817e6")},
        {{"176.1e3", "2.09955e6", "new", kNoSecondTerm}, None()},
        {Near("10.89e6", "10.8817e6"), None()}},
       linear::Routh(t.denominator));
  groups.push_back(g);
  groups.push_back(Arithmetic("(B.19)", low, {155.9e-6, 142.9e-3, 191.44, 176.1e3, 10.89e6},
                              {{Good("-680.3e-3"), Good("10.89e6")},
                               {{"176.1e3", "2.4636e6", "new", kNoSecondTerm}, None()},
                               {Good("10.89e6"), None()}}));

  const Case high = make({.bulk_modulus_psi = 230e3});
  const linear::TransferFunction h = linear::ThesisTransferFunction(high.Coefficients());
  Group f("(3.19): beta = 230,000 psi, a4 = 0.2901", high);
  Numbers(f, "K", "", {Good("4.662e6")}, h.numerator);
  Numbers(f, "a", "",
          {Near("74.56e-6", "74.5355e-6"),
           Near("73.38e-3", "73.1496e-3"),
           Near("191.44", "191.580"),
           {"176.1", "175.767e3", "14", "the factor 10³ is missing"},
           Near("10.89e6", "10.8817e6")},
          h.denominator);
  Rows(f,
       {{Near("12.50", "12.4832"), Near("10.89e6", "10.8817e6")},
        {{"176.1e3", "112.002e3", "new", kNoSecondTerm}, None()},
        {Near("10.89e6", "10.8817e6"), None()}},
       linear::Routh(h.denominator));
  groups.push_back(f);
  groups.push_back(Arithmetic("(3.19) with errata 14", high, {74.56e-6, 73.38e-3, 191.44, 176.1e3, 10.89e6},
                              {{Sloppy("12.50", "12.508"), Good("10.89e6")},
                               {{"176.1e3", "112.21e3", "new", kNoSecondTerm}, None()},
                               {Good("10.89e6"), None()}}));
}

Printed Other(const char* text, const char* right) {
  return {text, right, "17", kOtherRc};
}

struct Compensated {
  const char* where;
  std::initializer_list<Printed> numerator;
  std::initializer_list<Printed> denominator;
  std::initializer_list<RouthRow> rows;
  linear::Polynomial printed;
  std::initializer_list<RouthRow> arithmetic;
};

void Append(const MakeCase& make, const Stabilizer& stabilizer, const Compensated& p, Groups& groups) {
  const Case c = make({.stabilizer = stabilizer});
  const linear::TransferFunction t = linear::ThesisTransferFunction(c.Coefficients());
  Group g(p.where, c);
  g.Number("tau_p in the numerator", "s", p.numerator.begin()->text, t.numerator[0] / t.numerator[1],
           ReasonOf(*p.numerator.begin()));
  g.Number("K", "", "4.662e6", t.numerator[1]).note =
      "C3 of (G.15) as printed lacks the factor alpha of (a1 + a2) B7 (not in the errata); the printed "
      "numbers have it";
  Numbers(g, "a", "", p.denominator, t.denominator);
  Rows(g, p.rows, linear::Routh(t.denominator));
  groups.push_back(g);
  groups.push_back(Arithmetic(p.where, c, p.printed, p.arithmetic));
}

}  // namespace

void AppendTransferFunctions(const MakeCase& make, Groups& groups) {
  Uncompensated(make, groups);
  const Printed a5 = Near("10.9e6", "10.8817e6");
  Append(make, TableV()[0],
         {"Section 5.4, R = 35.85, C = 0.139",
          {Near("4.98", "4.97287")},
          {Near("772e-6", "775.008e-6"), Near("714e-3", "0.715171"), Near("954", "957.898"),
           Near("872e3", "873533"), Good("54e6"), a5},
          {{Near("11.2", "11.278"), Near("54.0e6", "5.42652e7")},
           {Near("-2.57e6", "-2.56758e6"), a5},
           {Good("54e6"), None()},
           {a5, None()}},
          {772e-6, 714e-3, 954.0, 872e3, 54e6, 10.9e6},
          {{Good("11.2"), Good("54.0e6")},
           {Sloppy("-2.57e6", "-2.5805e6"), Good("10.9e6")},
           {Good("54e6"), None()},
           {Good("10.9e6"), None()}}},
         groups);
  Append(make, TableV()[1],
         {"Section 5.4, R = 1.33, C = 0.680",
          {Good("0.90")},
          {Other("28e-6", "140.65e-6"), Other("33e-3", "0.162532"), Other("40.6", "201.731"),
           Other("32e3", "158619"), Other("2.1e6", "9.93659e6"), a5},
          {{Other("13.5", "64.4669"), Other("2.1e6", "9.92718e6")},
           {Other("27e3", "133591"), a5},
           {Other("2.1e6", "9.92193e6"), None()},
           {a5, None()}},
          {28e-6, 33e-3, 40.6, 32e3, 2.1e6, 10.9e6},
          {{Sloppy("13.5", "13.448"), Good("2.1e6")},
           {Good("27e3"), Good("10.9e6")},
           {Good("2.1e6"), None()},
           {Good("10.9e6"), None()}}},
         groups);
  Append(make, TableV()[2],
         {"Section 5.4, R = 0.166, C = 0.693",
          {{"0.005", "0.115113", "17", "R C = 0.115 s; printed 0.05 s in Table V and 0.005 s here"}},
          {Other("8.14e-6", "17.940e-6"), Other("23.3e-3", "0.0511066"), Other("23.5", "51.6067"),
           Other("9.35e3", "20336.5"), Other("716e3", "1.3674e6"), a5},
          {{Other("20.2", "44.4679"), Other("712e3", "1.36358e6")},
           {Other("8.53e3", "18769.4"), a5},
           {Other("686e3", "1.3378e6"), None()},
           {a5, None()}},
          {8.14e-6, 23.3e-3, 23.5, 9.35e3, 716e3, 10.9e6},
          {{Good("20.2"), Good("712e3")},
           {Good("8.53e3"), Good("10.9e6")},
           {Good("686e3"), None()},
           {Good("10.9e6"), None()}}},
         groups);
}

}  // namespace servohil::thesis
