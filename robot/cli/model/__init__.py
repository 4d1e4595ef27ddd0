"""Commands ``bigant model``: the model without a robot. Arguments here, work below."""
