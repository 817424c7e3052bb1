"""An error-controlled simulator of rigid boxes in compliant contact, made to label layouts."""
