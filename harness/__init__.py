"""steadyload: how stable is a pallet while it is being loaded?

Data flows one way: layouts -> methods -> studies -> reports.
"""
