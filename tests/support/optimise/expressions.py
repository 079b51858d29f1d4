"""Factored expressions: their operations, and the polynomials that they compute."""

from fractions import Fraction

from bladesmith.codegen.optimise.factor.factor import Atom, Constant, Product, Sum, multiply


def operation_count(expressions):
    """Multiplications and additions, each node (by identity) counted once.

    A coefficient of +-1 is free, any other is one multiplication; n factors are n - 1 multiplications and n
    terms n - 1 additions.
    """
    multiplications = additions = 0
    for node in _nodes(expressions):
        if isinstance(node, Sum):
            additions += len(node.terms) - 1
            multiplications += sum(
                1 for term, value in node.terms if value not in (1, -1) and not isinstance(term, Constant)
            )
        elif isinstance(node, Product):
            multiplications += len(node.factors) - 1
    return multiplications, additions


def expand(expression):
    """The polynomial that an expression computes."""
    memo = {}
    for node in _nodes([expression]):
        if isinstance(node, Atom):
            memo[id(node)] = {((node.index, 1),): Fraction(1)}
        elif isinstance(node, Constant):
            memo[id(node)] = {(): node.value} if node.value else {}
        elif isinstance(node, Sum):
            total = {}
            for term, value in node.terms:
                for monomial, amount in memo[id(term)].items():
                    total[monomial] = total.get(monomial, Fraction(0)) + value * amount
            memo[id(node)] = {monomial: amount for monomial, amount in total.items() if amount}
        else:
            product = {(): Fraction(1)}
            for inner in node.factors:
                product = multiply(product, memo[id(inner)])
            memo[id(node)] = product
    return memo[id(expression)]


def _children(node):
    if isinstance(node, Sum):
        return [term for term, _ in node.terms]
    if isinstance(node, Product):
        return list(node.factors)
    return []


def _nodes(expressions):
    """All nodes by identity, children first."""
    done = set()
    order = []
    stack = [(expression, False) for expression in reversed(list(expressions))]
    while stack:
        node, visited = stack.pop()
        if visited:
            order.append(node)
        elif id(node) not in done:
            done.add(id(node))
            stack.append((node, True))
            stack.extend((child, False) for child in reversed(_children(node)))
    return order
